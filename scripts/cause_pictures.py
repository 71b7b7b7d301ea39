"""Makes doc/pictures/causes/: the signature of each cause, from a simulated session that has it.

  scripts/cause_pictures.py [BIN_FOLDER] [CAUSE ...]

Takes the session of each cause from the command in doc/manual/causes.md, diagnoses it, and saves the
chart that the diagnosis' own page draws, as one small SVG. Needs chromium; standard library only.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "live"))
from drive import Page, Pipe  # noqa: E402

# The panels of a figure, their titles and the legend, as one SVG.
COLLECT = """(() => {
  const figure = document.querySelector('#cause_%d figure');
  const panels = [...figure.querySelectorAll('.panel')].map((panel) => {
    const svg = panel.querySelector('svg.plot');
    const [, , width, height] = svg.getAttribute('viewBox').split(' ').map(Number);
    return {title: panel.querySelector('.panel-title').textContent, width, height, inner: svg.outerHTML};
  });
  const legend = [...figure.querySelectorAll('.legend > span')].map((item) =>
    ({text: item.textContent, key: item.querySelector('svg').outerHTML}));
  return JSON.stringify({panels, legend});
})()"""


def escaped(text):
    return text.replace("&", "&amp;").replace("<", "&lt;")


def shrunk(svg):
    """Marks of one shape become uses of it, numbers get one decimal."""
    svg = re.sub(r"<[^>]+>", lambda tag: re.sub(r"(\d+\.\d)\d+", r"\1", tag.group(0)), svg)
    svg = re.sub(r' aria-[a-z]+="[^"]*"', "", svg)
    shapes, most = {}, 480
    mark = r'<path transform="[^"]*" d="(?!M0,0)[^"]*"></path>'  # the ticks of an axis begin at 0
    count = len(re.findall(mark, svg))
    if count > most:  # an even choice of the marks: the shape stays, the file is small
        every, number = -(-count // most), iter(range(count))
        svg = re.sub(mark, lambda m: m.group(0) if next(number) % every == 0 else "", svg)
    def use(match):
        name = shapes.setdefault(match.group(2), f"s{len(shapes)}")
        return f'<use href="#{name}"{match.group(1)}/>'
    marks = re.findall(r'<path( transform="[^"]*") d="([^"]*)"></path>', svg)
    often = {shape for _, shape in marks if sum(1 for _, other in marks if other == shape) > 5}
    svg = re.sub(r'<path( transform="[^"]*") d="([^"]*)"></path>',
                 lambda m: use(m) if m.group(2) in often else m.group(0), svg)
    defs = "".join(f'<path id="{name}" d="{shape}"/>' for shape, name in shapes.items())
    return svg.replace(">", f"><defs>{defs}</defs>", 1) if defs else svg


def picture(drawn, title):
    in_a_row, gap, top = min(3, len(drawn["panels"])), 12, 22
    y, x, row, body = 0, 8, 0, []
    for item in drawn["legend"]:
        key = item["key"].replace("<svg", f'<svg x="{x}" y="{y + 4}"', 1)
        body.append(f'{key}<text x="{x + 32}" y="{y + 14}">{escaped(item["text"])}</text>')
        x += 50 + 7 * len(item["text"])
    y, width = 26, 0
    for at in range(0, len(drawn["panels"]), in_a_row):
        x, row = 0, 0
        for panel in drawn["panels"][at:at + in_a_row]:
            inner = panel["inner"].replace("<svg", f'<svg x="{x}" y="{y + top}"', 1)
            inner = re.sub(r' style="[^"]*"', "", inner, count=1)
            body.append(f'<text x="{x + 8}" y="{y + 15}" font-weight="600">{escaped(panel["title"])}</text>{inner}')
            x += panel["width"] + gap
            row = max(row, panel["height"])
        width, y = max(width, x - gap), y + row + top + 6
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {y:.0f}" width="{width:.0f}" height="{y:.0f}" '
            'font-family="system-ui,sans-serif" font-size="12" fill="#16202a" style="color:#16202a;background:#fff">'
            f"<title>{escaped(title)}</title>{''.join(body)}</svg>\n")


def main():
    words = sys.argv[1:]
    binaries = pathlib.Path(words.pop(0) if words and "/" in words[0] else ROOT / "build/release/bin").resolve()
    out = ROOT / "doc" / "pictures" / "causes"
    out.mkdir(parents=True, exist_ok=True)
    page_text = (ROOT / "doc/manual/causes.md").read_text(encoding="utf-8")
    commands = re.findall(r"`sixdial-mock-rig (--bundle (\w+) [^`]*)`", page_text)
    if not commands:
        sys.exit("cause_pictures: no command in doc/manual/causes.md: sixdiald --print-causes writes it")
    troubles = []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        pipe = Pipe(folder, 1280)
        page = Page(pipe)
        try:
            for options, cause in commands:
                if words and cause not in words:
                    continue
                subprocess.run([binaries / "sixdial-mock-rig", *options.split()], cwd=folder, check=True)
                subprocess.run([binaries / "sixdial", "--quiet", "diagnose", f"{cause}/", "--bootstrap", "0", "--no-gain",
                                "--report", "page.html", "-o", "diagnosis.json"], cwd=folder, check=True,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                found = json.loads(pathlib.Path(folder, "diagnosis.json").read_text(encoding="utf-8"))["causes"]
                named = [i for i, each in enumerate(found) if each["cause"] == cause]
                if not named:
                    troubles.append(f"{cause}: found instead {[(each['cause'], each['where']) for each in found]}")
                    continue
                page.open(pathlib.Path(folder, "page.html").as_uri(), 1000, 900)
                page.until("document.querySelectorAll('[data-drawn=yes]').length > 0")
                first = page.evaluate("[...document.querySelectorAll('section[id^=cause_]')].map((s) => s.id).join()").split(",")
                index = int(first[named[0]].split("_")[1])
                drawn = json.loads(page.evaluate(COLLECT % index))
                text = shrunk(picture(drawn, f"{cause}: {options}"))
                (out / f"{cause}.svg").write_text(text, encoding="utf-8")
                print(f"{cause}: {len(text)} bytes, found at {found[named[0]]['where']}, {found[named[0]]['certainty']}", flush=True)
        finally:
            pipe.send("Browser.close")
            pipe.browser.wait(timeout=10)
    if troubles:
        sys.exit("\n".join(troubles))


if __name__ == "__main__":
    main()
