"""Runs the manual: manual_test.py page|causes|map SOURCE_DIR BIN_DIR [PAGE]."""
import csv
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile


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


def run_page(source, binaries, page):
    with tempfile.TemporaryDirectory(prefix="sixdial-manual-", ignore_cleanup_errors=True) as folder:
        shell(blocks(source, page), source, binaries, folder)


def causes(source, binaries):
    printed = subprocess.run([os.path.join(binaries, "sixdiald"), "--print-causes"], capture_output=True,
                             text=True, check=True).stdout
    kept = pathlib.Path(source, "doc/manual/causes.md").read_text(encoding="utf-8")
    if printed != kept:
        sys.exit("doc/manual/causes.md is not what sixdiald --print-causes prints: print it anew")
    if printed.count("\n## ") < 15 or "| action |  |" in printed or "| signature |  |" in printed:
        sys.exit("a cause has no words")


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
        {"causes": causes, "map": residual_map}[what](source_dir, bin_dir)
