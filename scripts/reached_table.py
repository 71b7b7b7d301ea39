"""The table of doc/diagnosis.md: reached_table.py FOLDER, which scripts/reached.sh filled."""
import json
import pathlib
import sys

WAYS = ("kinematics", "full", "extended", "extended_full")


def load(folder, name):
    path = folder / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def means(validation):
    """reached and predicted [mm] by way."""
    found = {}
    for way in validation["methods"]:
        reached = (way["errors"] or {}).get("mean_mm")
        predicted = (way["predicted"] or {}).get("mean_mm")
        found[way["id"]] = (reached, predicted)
    return found


def cell(pair):
    reached, predicted = pair
    if reached is None:
        return ""
    return f"{reached:.4f} / " + ("-" if predicted is None else f"{predicted:.4f}")


def inside(truth, parameters):
    """How many of the recommended 95 % intervals hold the truth."""
    true = truth["true_robot"]
    rows = [p for p in parameters if p["name"] in true]
    hold = sum(p["low_95"] <= true[p["name"]] <= p["high_95"] for p in rows)
    return f"{hold} of {len(rows)}"


def main():
    folders = sorted(p for p in pathlib.Path(sys.argv[1]).iterdir() if p.is_dir())
    print("| rig | named | " + " | ".join(WAYS) + " | recommended (before, after validation) | intervals that hold |")
    print("|---|---|" + "---|" * len(WAYS) + "---|---|")
    for folder in folders:
        validation = load(folder, "validation")
        if validation is None:
            print(f"| {folder.name} | did not end: see log.txt | | | | | | |")
            continue
        diagnosis = load(folder, "diagnosis")
        before = load(folder, "before_validation")
        after = load(folder, "recommendation")
        named = ", ".join(
            f"{c['cause']}@{c['where']}" for c in diagnosis["causes"] if c["where"] != "samples")
        if diagnosis["unexplained"]["significant"]:
            left = ", ".join(diagnosis["unexplained"]["depends_on"]) or "scatter"
            named += ("; " if named else "") + f"left: {left}"
        found = means(validation)
        cells = [cell(found[way]) if way in found else "" for way in WAYS]
        truth = load(folder, "truth")
        print(
            f"| {folder.name} | {named or 'nothing'} | " + " | ".join(cells)
            + f" | {before['by']}, {after['by']} | {inside(truth, after['parameters'])} |")


main()
