"""One picture through headless Chromium (standard library and tests/live/drive.py).

  picture.py live URL OUT.png N    the live page, once N points are stored
  picture.py text FILE OUT.png     a terminal's text
  picture.py page FILE OUT.png     the first screen of a page
"""
import html
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tests" / "live"))
from drive import Page, Pipe  # noqa: E402

kTerminal = """<!doctype html><meta charset="utf-8"><style>body{margin:0;background:#14191e}
pre{margin:0;padding:18px 22px;color:#e6edf3;font:15px/1.32 "DejaVu Sans Mono",monospace}</style><pre>%s</pre>"""


def main():
    kind, source, out = sys.argv[1:4]
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        pipe = Pipe(folder, 1280)
        page = Page(pipe)
        try:
            if kind == "live":
                page.open(source, 1280, 900)
                page.until(f"document.getElementById('bar').value >= {int(sys.argv[4])} &&"
                           " !document.getElementById('settle-bar').hidden")
                page.shot(out, True)
            elif kind == "text":
                shown = pathlib.Path(folder, "terminal.html")
                shown.write_text(kTerminal % html.escape(pathlib.Path(source).read_text()))
                page.open(shown.as_uri(), 1120, 400)
                page.shot(out, True)
            else:
                page.open(pathlib.Path(source).resolve().as_uri(), 1000, 1900)
                page.shot(out, False)
        finally:
            pipe.send("Browser.close")
            pipe.browser.wait(timeout=10)


if __name__ == "__main__":
    main()
