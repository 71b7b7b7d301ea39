"""Runs the manual: manual_test.py page|causes|sessions|map|links|columns SOURCE_DIR BIN_DIR [PAGE]."""
import csv
import json
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import xml.dom.minidom


def shell(script, source, binaries, folder):
    """One bash for all blocks; whatever they left running is ended with their process group."""
    environment = dict(os.environ, PATH=f"{binaries}:{os.environ['PATH']}", SIXDIAL_SOURCE=source,
                       XDG_RUNTIME_DIR=folder)
    with open(os.path.join(folder, "said.txt"), "w+", encoding="utf-8") as said:
        process = subprocess.Popen(["bash", "-euo", "pipefail", "-c", script], cwd=folder, env=environment,
                                   stdout=said, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            code = process.wait(timeout=240)
        finally:
            try:
                os.killpg(process.pid, signal.SIGTERM)
            except ProcessLookupError:
                pass
        said.seek(0)
        text = said.read()
    if code != 0:
        sys.exit(f"ended with {code}:\n{script}\n--- said:\n{text[-4000:]}")
    return text


def blocks(source, page):
    text = pathlib.Path(source, "doc/manual", page + ".md").read_text(encoding="utf-8")
    found = re.findall(r"^```bash\n(.*?)^```$", text, re.M | re.S)
    if not found:
        sys.exit(f"{page}.md has no bash block; is the pattern still right?")
    return "\n".join(found)


def run_as_written(source, binaries, page):
    """As a person types it: nothing is set but where the programs are, and nothing is left running at the end."""
    with tempfile.TemporaryDirectory(prefix="sixdial-manual-") as home:
        environment = {"PATH": f"{binaries}:/usr/local/bin:/usr/bin:/bin", "HOME": home, "LANG": "C.UTF-8"}
        said = os.path.join(home, "said.txt")
        with open(said, "w", encoding="utf-8") as out:
            process = subprocess.Popen(["bash", "-euo", "pipefail", "-c", blocks(source, page)], cwd=home, env=environment,
                                       stdout=out, stderr=subprocess.STDOUT, start_new_session=True)
            try:
                code = process.wait(timeout=240)
                left = subprocess.run(["ps", "-o", "args=", "-s", str(process.pid)], capture_output=True, text=True).stdout
            finally:
                try:
                    os.killpg(process.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
        text = pathlib.Path(said).read_text(encoding="utf-8")
        folders = re.findall(r"/tmp/sixdial-lesson-\w+", text)
        for folder in set(folders):
            shutil.rmtree(folder, ignore_errors=True)
        if code != 0:
            sys.exit(f"{page}.md ended with {code}:\n{text[-4000:]}")
        if left.strip():
            sys.exit(f"{page}.md leaves running:\n{left}")


def run_page(source, binaries, page):
    if page == "first_session_mock":
        return run_as_written(source, binaries, page)
    with tempfile.TemporaryDirectory(prefix="sixdial-manual-", ignore_cleanup_errors=True) as folder:
        shell(blocks(source, page), source, binaries, folder)


def causes(source, binaries):
    printed = subprocess.run([os.path.join(binaries, "sixdiald"), "--print-causes"], capture_output=True,
                             text=True, check=True).stdout
    kept = pathlib.Path(source, "doc/manual/causes.md").read_text(encoding="utf-8")
    if printed != kept:
        sys.exit("doc/manual/causes.md is not what sixdiald --print-causes prints: print it anew")
    causes_named = re.findall(r"^## .* \(`(\w+)`\)$", printed, re.M)
    if len(causes_named) < 15 or re.search(r"^\| [^|]+ \|  \|$", printed, re.M):
        sys.exit("a cause has no words")
    for cause in causes_named:
        picture = pathlib.Path(source, "doc/pictures/causes", cause + ".svg")
        if not picture.is_file():
            sys.exit(f"{picture} is missing: scripts/cause_pictures.py {cause}")
        svg = picture.read_text(encoding="utf-8")
        xml.dom.minidom.parseString(svg)
        command = re.search(rf"`sixdial-mock-rig (--bundle {cause} [^`]*)`", printed).group(1)
        if f"<title>{cause}: {command}</title>" not in svg or len(svg) > 100_000:
            sys.exit(f"{picture} is of another session, or too large: scripts/cause_pictures.py {cause}")


def cause_sessions(source, binaries):
    """The commands under the pictures: every session is made, three kinds are named again by the diagnosis."""
    page = pathlib.Path(source, "doc/manual/causes.md").read_text(encoding="utf-8")
    commands = re.findall(r"^`(sixdial-mock-rig --bundle (\w+) [^`]*)`, `(sixdial diagnose [^`]*)`$", page, re.M)
    if len(commands) < 15:
        sys.exit(f"{len(commands)} commands in causes.md; is the pattern still right?")
    script = "\n".join(f"{make}\ntest -s {cause}/session.csv" for make, cause, _ in commands)
    for _, cause, diagnose in commands:
        if cause in ("joint_backlash", "dial_gain", "base_drift"):
            script += f"\n{diagnose} --quiet --bootstrap 0 --no-gain -o {cause}.json"
    with tempfile.TemporaryDirectory(prefix="sixdial-causes-", ignore_cleanup_errors=True) as folder:
        shell(script, source, binaries, folder)
        for cause in ("joint_backlash", "dial_gain", "base_drift"):
            found = json.loads(pathlib.Path(folder, cause + ".json").read_text(encoding="utf-8"))["causes"]
            if cause not in [each["cause"] for each in found]:
                sys.exit(f"{cause} is not found in its own session: {[each['cause'] for each in found]}")


def anchors(text):
    """What a heading is called in a link, and explicit anchors."""
    names = set(re.findall(r'<a id="([^"]+)">', text))
    for heading in re.findall(r"^#+ (.*)$", text, re.M):
        words = re.sub(r"[^\w\- ]", "", heading.lower()).strip()
        names.add(words.replace(" ", "-"))
    return names


def links(source, _):
    """Every relative link and picture of every page leads somewhere, and every page of the manual is linked."""
    pages = [*pathlib.Path(source).glob("*.md"), *pathlib.Path(source, "doc").rglob("*.md")]
    troubles, followed, reached = [], 0, set()
    for page in pages:
        text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            aim = (page.parent / path).resolve() if path else page
            followed += 1
            if not aim.exists():
                troubles.append(f"{page.relative_to(source)}: {target} is not there")
            elif anchor and aim.suffix == ".md" and anchor not in anchors(aim.read_text(encoding="utf-8")):
                troubles.append(f"{page.relative_to(source)}: {target}: no such heading")
            reached.add(aim)
    for page in pathlib.Path(source, "doc").rglob("*.md"):
        if page.resolve() not in reached and "decisions" not in page.parts:
            troubles.append(f"{page.relative_to(source)}: no page links to it")
    if troubles or followed < 60:
        sys.exit("\n".join(troubles) or f"only {followed} links; is the pattern still right?")


def columns(source, binaries):
    """Each column of the views and of a report's own CSV files stands in files.md."""
    page = pathlib.Path(source, "doc/manual/files.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([^`]+)`", page))
    script = """
sixdiald --db sixdial.db 2> log & until sixdial hello > hello.txt 2>&1; do sleep 0.1; done
sixdial session import "$SIXDIAL_SOURCE/tests/data/sessions/00" --name one
sixdial calibrate one --quiet --seed 1 --particles 8 --qpso1-iterations 3 --qpso2-iterations 5 --anfis-epochs 5
sixdial report one -o report
sixdial shutdown"""
    troubles, checked = [], 0
    with tempfile.TemporaryDirectory(prefix="sixdial-columns-", ignore_cleanup_errors=True) as folder:
        shell(script, source, binaries, folder)
        base = sqlite3.connect(f"file:{folder}/sixdial.db?mode=ro", uri=True)
        views = [row[0] for row in base.execute("SELECT name FROM sqlite_master WHERE type = 'view' AND name LIKE 'v\\_%' ESCAPE '\\'")]
        found = {view: [each[0] for each in base.execute(f"SELECT * FROM {view} LIMIT 0").description] for view in views}
        base.close()
        for name in ("points", "table2", "table6", "residual_by", "residual_by_dial", "convergence", "parameters_by_iteration", "schema"):
            with open(os.path.join(folder, "report", name + ".csv"), encoding="utf-8") as file:
                found[name + ".csv"] = next(csv.reader(file))
        with open(os.path.join(source, "tests/data/sessions/00/session.csv"), encoding="utf-8") as file:
            found["session.csv"] = [c for c in next(csv.reader(file)) if not c.startswith("dial_")]
    for where, names in found.items():
        if where not in named:
            troubles.append(f"{where} is not in files.md")
        for column in names:
            checked += 1
            plain = re.sub(r"^g[12]_", "...", column) if where == "table6.csv" else column
            plain = re.sub(r"^.*(_e[xy]_mm|_error_mm)$", r"...\1", plain)
            plain = plain.replace("......", "...")
            if not {plain, plain.replace("...", "..._")} & named:
                troubles.append(f"{where}: column {column} is not in files.md")
    if troubles or len(views) < 4 or checked < 80:
        sys.exit("\n".join(troubles) or f"{len(views)} views, {checked} columns; is the pattern still right?")


def residual_map(source, binaries):
    """The same figures from the SQLite file and from the report's CSV, and both pictures."""
    script = """
sixdiald --db sixdial.db 2> log & until sixdial hello > hello.txt 2>&1; do sleep 0.1; done
sixdial session import "$SIXDIAL_SOURCE/tests/data/sessions/00" --name one
sixdial calibrate one --quiet --seed 1
sixdial report one -o one-report
map="/usr/bin/python3 $SIXDIAL_SOURCE/examples/notebook/residual_map.py"
$map --db sixdial.db --session one --svg base.svg > base.txt
$map --report one-report --svg report.svg > report.txt
sixdial shutdown"""
    with tempfile.TemporaryDirectory(prefix="sixdial-map-", ignore_cleanup_errors=True) as folder:
        shell(script, source, binaries, folder)
        tables = []
        for name in ("base", "report"):
            rows = list(csv.reader(pathlib.Path(folder, name + ".txt").open(encoding="utf-8")))
            tables.append({(m, s): (float(mean), float(most), int(n)) for m, s, mean, most, n in rows})
            picture = pathlib.Path(folder, name + ".svg").read_text(encoding="utf-8")
            if picture.count('class="residual"') != 150:  # points of the session
                sys.exit(f"{name}.svg has {picture.count('class=')} arrows, 150 expected")
        base, report = tables
        if set(base) != set(report) or len(base) < 8:
            sys.exit(f"methods differ: {sorted(base)} and {sorted(report)}")
        for key, row in base.items():
            if any(abs(a - b) > 2e-6 for a, b in zip(row, report[key])):  # six decimals printed
                sys.exit(f"{key}: {row} from the database, {report[key]} from the report")
        if not base[("before", "G2")][0] > 10 * base[("ekf_dqpso", "G2")][0]:
            sys.exit("the calibration does not show in the figures")


if __name__ == "__main__":
    what, source_dir, bin_dir = sys.argv[1:4]
    if what == "page":
        run_page(source_dir, bin_dir, sys.argv[4])
    else:
        {"causes": causes, "sessions": cause_sessions, "map": residual_map, "links": links,
         "columns": columns}[what](source_dir, bin_dir)
