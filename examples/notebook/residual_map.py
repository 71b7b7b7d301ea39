#!/usr/bin/env python3
"""The residual map of a session with pandas: from the SQLite file, and from the CSV bundle of a report.

    residual_map.py --db sixdial.db --session monday --svg map.svg
    residual_map.py --report monday-report --svg map.svg

A residual is measured minus modelled position in the table frame, in mm. Needs python3-pandas alone; the
picture is SVG, written by hand. Prints one line a method: mean, maximum, number of points.
"""
import argparse
import json
import os
import sqlite3
import sys

import pandas


def from_database(path, session):
    """Views have units in their column names; the newest calibration is a JSON document beside them."""
    with sqlite3.connect(f"file:{path}?mode=ro", uri=True) as base:
        found = pandas.read_sql(
            "SELECT result FROM v_results WHERE session = ? AND kind = 'calibration' "
            "ORDER BY result_id DESC LIMIT 1", base, params=(session,))
        samples = pandas.read_sql(
            "SELECT set_name, point, repeat, target_x_mm, target_y_mm, temperature_c FROM v_samples "
            "WHERE session = ? AND is_live = 1 ORDER BY sample_id", base, params=(session,))
    if found.empty:
        sys.exit(f"residual_map: session {session} has no calibration: sixdial calibrate {session}")
    document = json.loads(found["result"][0])
    rows = []
    for point in document["points"]:
        for method, residual in zip(document["methods"], point["residual_mm"]):
            if residual is not None:
                rows.append({"sample": point["sample"], "method": method["id"].replace("+", "_"),
                             "dx_mm": residual[0], "dy_mm": residual[1]})
    return pandas.DataFrame(rows).join(samples, on="sample").rename(columns={
        "set_name": "set", "target_x_mm": "x_mm", "target_y_mm": "y_mm"})


def from_report(folder):
    """points.csv: a row a sample, and for each method its residual."""
    table = pandas.read_csv(os.path.join(folder, "points.csv"))
    parts = []
    for column in [c for c in table.columns if c.endswith("_ex_mm")]:
        method = column[:-len("_ex_mm")]
        part = table[["set", "point", "repeat", "target_x_mm", "target_y_mm"]].rename(
            columns={"target_x_mm": "x_mm", "target_y_mm": "y_mm"})
        parts.append(part.assign(method=method, dx_mm=table[column], dy_mm=table[f"{method}_ey_mm"]))
    return pandas.concat(parts).dropna(subset=["dx_mm"])


def draw(rows, title):
    """Arrows from the target; the longest is 4 mm of the table long, and the scale is written above."""
    longest = max((rows["dx_mm"] ** 2 + rows["dy_mm"] ** 2).max() ** 0.5, 1e-9)
    times = 4.0 / longest
    left, right, low, high = rows["x_mm"].min() - 6, rows["x_mm"].max() + 6, rows["y_mm"].min() - 6, rows["y_mm"].max() + 6
    text = 'font-size="1.1" font-family="sans-serif"'
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{left - 3:.2f} {-high - 6:.2f} {right - left + 4:.2f} {high - low + 10:.2f}" width="560">',
           f'<text x="{left:.2f}" y="{-high - 3.6:.2f}" {text}>{title}: longest {longest:.4f} mm, drawn {times:.3g} times as long</text>',
           f'<text x="{left:.2f}" y="{-high - 1.6:.2f}" {text}>table frame, mm; <tspan fill="#0b4f82">G1 fitted</tspan>, '
           f'<tspan fill="#d55e00">G2 not</tspan></text>',
           f'<rect x="{left:.2f}" y="{-high:.2f}" width="{right - left:.2f}" height="{high - low:.2f}" fill="none" stroke="#c9d1d9" stroke-width="0.1"/>']
    out += [f'<text x="{x}" y="{-low + 1.6:.2f}" text-anchor="middle" {text}>{x}</text>' for x in range(int(left // 10 + 1) * 10, int(right) + 1, 10)]
    out += [f'<text x="{left - 0.4:.2f}" y="{-y + 0.4}" text-anchor="end" {text}>{y}</text>' for y in range(int(low // 10 + 1) * 10, int(high) + 1, 10)]
    for row in rows.itertuples():
        colour = "#0b4f82" if row.set == "G1" else "#d55e00"
        x, y = row.x_mm, -row.y_mm
        out.append(f'<circle cx="{x:.3f}" cy="{y:.3f}" r="0.35" fill="{colour}"/><line class="residual" x1="{x:.3f}" y1="{y:.3f}" '
                   f'x2="{x + times * row.dx_mm:.3f}" y2="{y - times * row.dy_mm:.3f}" stroke="{colour}" stroke-width="0.25"/>')
    return "\n".join(out) + "\n</svg>\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--db")
    parser.add_argument("--session")
    parser.add_argument("--report")
    parser.add_argument("--svg")
    parser.add_argument("--method", default="before")
    options = parser.parse_args()
    if bool(options.report) == bool(options.db and options.session):
        parser.error("give either --db FILE --session NAME, or --report FOLDER")
    rows = from_report(options.report) if options.report else from_database(options.db, options.session)
    rows = rows.assign(error_mm=(rows["dx_mm"] ** 2 + rows["dy_mm"] ** 2) ** 0.5)
    for (method, name), group in rows.groupby(["method", "set"], sort=True):
        print(f"{method},{name},{group['error_mm'].mean():.6f},{group['error_mm'].max():.6f},{len(group)}")
    if options.svg:
        chosen = rows[rows["method"] == options.method]
        if chosen.empty:
            sys.exit(f"residual_map: no method {options.method}; there are {', '.join(sorted(rows['method'].unique()))}")
        with open(options.svg, "w", encoding="utf-8") as file:
            file.write(draw(chosen, options.method))


if __name__ == "__main__":
    main()
