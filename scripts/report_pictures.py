"""Makes doc/pictures/report/ and doc/pictures/rig.svg: the report that doc/manual/report.md walks through.

  scripts/report_pictures.py [BIN_FOLDER]

Runs the page's own commands. Needs chromium; standard library only.
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from cause_pictures import ROOT, Page, Pipe, picture, shrunk

COLLECT = """(() => {
  const figure = document.querySelector('#figure_%s');
  const panels = [...figure.querySelectorAll('.panel')].map((panel) => {
    const svg = panel.querySelector('svg.plot');
    const [, , width, height] = svg.getAttribute('viewBox').split(' ').map(Number);
    const title = panel.querySelector('.panel-title');
    return {title: title.firstChild.textContent, width, height, inner: svg.outerHTML};
  });
  const legend = [...figure.querySelectorAll('.legend > span')].map((item) =>
    ({text: item.textContent, key: item.querySelector('svg').outerHTML}));
  return JSON.stringify({panels, legend});
})()"""


def main():
    binaries = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/bin").resolve()
    out = ROOT / "doc" / "pictures" / "report"
    out.mkdir(parents=True, exist_ok=True)
    commands = re.findall(r"^(sixdial-mock-rig|sixdial) (.*--(?:bundle|diagnose).*)$",
                          (ROOT / "doc/manual/report.md").read_text(encoding="utf-8"), re.M)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        for program, words in commands:
            subprocess.run([binaries / program, *words.split()], cwd=folder, check=True, stdout=subprocess.DEVNULL)
        subprocess.run([binaries / "sixdial", "rig", "draw", f"{folder}/backlash/rig.toml", "-o", f"{folder}/rig.svg"], check=True,
                       stdout=subprocess.DEVNULL)
        shutil.copy(f"{folder}/rig.svg", ROOT / "doc/pictures/rig.svg")
        pipe = Pipe(folder, 1280)
        page = Page(pipe)
        try:
            page.open(pathlib.Path(folder, "report/report.html").as_uri(), 1000, 1150)
            page.until("document.querySelectorAll('[data-drawn=yes]').length > 3")
            page.shot(out / "first.png", False)
            for name in ("residual_map", "residual_by"):
                text = shrunk(picture(json.loads(page.evaluate(COLLECT % name)), name))
                (out / f"{name}.svg").write_text(text, encoding="utf-8")
                print(f"{name}: {len(text)} bytes")
        finally:
            pipe.send("Browser.close")
            pipe.browser.wait(timeout=10)


if __name__ == "__main__":
    main()
