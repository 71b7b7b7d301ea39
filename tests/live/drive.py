"""A browser's page driven from outside: JSON lines in, JSON lines out.

  {"open": URL, "width": W, "height": H}   {"do": JAVASCRIPT}   {"until": JAVASCRIPT}  
  {"shot": FILE, "full": true}             {"keys": TEXT}       {"complaints": true}        {"tab": PART OF URL}
  {"size": [W, H], "touch": true, "dark": true}                 {"press": "Tab" or "Enter"}
  {"complaints_here": true}

`until` asks again until the expression is true, for at most a minute. Each line is answered by
{"value": ...} or {"error": text}. Standard library and tests/report/browser.py only.
"""
import base64
import json
import pathlib
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "report"))
from browser import Pipe  # noqa: E402

PATIENCE_S = 60.0


class Page:
    def __init__(self, pipe):
        self.pipe, self.session = pipe, None

    def open(self, url, width=1280, height=860):
        target = self.pipe.call("Target.createTarget", url="about:blank")
        self.session = self.pipe.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
        for domain in ("Page", "Log", "Runtime"):
            self.pipe.call(f"{domain}.enable", self.session)
        self.pipe.call("Emulation.setDeviceMetricsOverride", self.session, width=width, height=height,
                       deviceScaleFactor=1, mobile=False)
        self.pipe.events.clear()
        self.pipe.call("Page.navigate", self.session, url=url)
        self.pipe.wait("Page.loadEventFired")

    def evaluate(self, expression):
        out = self.pipe.call("Runtime.evaluate", self.session, expression=expression, awaitPromise=True,
                             returnByValue=True, userGesture=True)
        if "exceptionDetails" in out:
            raise RuntimeError(json.dumps(out["exceptionDetails"]))
        return out["result"].get("value")

    def until(self, expression):
        end = time.monotonic() + PATIENCE_S
        while True:
            value = self.evaluate(expression)
            if value:
                return value
            if time.monotonic() > end:
                raise TimeoutError(f"never true: {expression}\n" + self.evaluate("document.body.innerText"))
            time.sleep(0.05)

    def keys(self, text):
        for key in text:
            for kind in ("keyDown", "keyUp"):
                self.pipe.call("Input.dispatchKeyEvent", self.session, type=kind, key=key, text=key if kind == "keyDown" else "")

    def press(self, name):
        code, text = {"Tab": (9, ""), "Enter": (13, "\r")}[name]
        for kind in ("keyDown", "keyUp"):
            self.pipe.call("Input.dispatchKeyEvent", self.session, type=kind, key=name, code=name,
                           windowsVirtualKeyCode=code, text=text if kind == "keyDown" else "")

    def size(self, wide, high, touch, dark):
        self.pipe.call("Emulation.setDeviceMetricsOverride", self.session, width=wide, height=high,
                       deviceScaleFactor=1, mobile=touch)
        self.pipe.call("Emulation.setTouchEmulationEnabled", self.session, enabled=touch)
        self.pipe.call("Emulation.setEmulatedMedia", self.session,
                       features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def shot(self, path, full):
        shot = self.pipe.call("Page.captureScreenshot", self.session, captureBeyondViewport=full)
        pathlib.Path(path).write_bytes(base64.b64decode(shot["data"]))

    def complaints(self):
        return [e["params"] for e in self.pipe.events
                if e["method"] in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")]

    def targets(self):
        return [t for t in self.pipe.call("Target.getTargets")["targetInfos"] if t["type"] == "page"]

    def tab(self, part):
        """Goes over to the tab whose address has this part, once it is there."""
        end = time.monotonic() + PATIENCE_S
        while not (found := [t for t in self.targets() if part in t["url"]]):
            if time.monotonic() > end:
                raise TimeoutError(f"no tab with {part}: {[t['url'] for t in self.targets()]}")
            time.sleep(0.05)
        self.session = self.pipe.call("Target.attachToTarget", targetId=found[0]["targetId"], flatten=True)["sessionId"]

    def complaints_here(self):
        """Log and Runtime tell, once enabled, what a page has said since it was opened."""
        self.pipe.events.clear()
        for domain in ("Log", "Runtime"):
            self.pipe.call(f"{domain}.enable", self.session)
        self.evaluate("1")
        return self.complaints()

    def run(self, order):
        if "open" in order:
            return self.open(order["open"], order.get("width", 1280), order.get("height", 860))
        if "shot" in order:
            return self.shot(order["shot"], order.get("full", False))
        if "size" in order:
            return self.size(*order["size"], order.get("touch", False), order.get("dark", False))
        if "complaints" in order:
            return self.complaints()
        if "complaints_here" in order:
            return self.complaints_here()
        [(name, what)] = order.items()
        return {"do": self.evaluate, "until": self.until, "keys": self.keys, "tab": self.tab,
                "press": self.press}[name](what)


def main():
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        pipe = Pipe(profile, 1280)
        page = Page(pipe)
        try:
            for line in sys.stdin:
                try:
                    answer = {"value": page.run(json.loads(line))}
                except Exception as trouble:  # told to who drives
                    answer = {"error": f"{type(trouble).__name__}: {trouble}"}
                print(json.dumps(answer), flush=True)
        finally:
            try:
                pipe.send("Browser.close")
                pipe.browser.wait(timeout=10)
            except (BrokenPipeError, subprocess.TimeoutExpired):
                pipe.browser.kill()
                pipe.browser.wait()


if __name__ == "__main__":
    main()
