"""Opens a page in headless Chromium over its debugging pipe and prints what came of it as JSON:
requests (every URL asked for), complaints (console, exceptions, log), dom, and text as laid out.

  browser.py [--no-script] [--screenshot FILE [--width N]] page.html

Standard library only. With --no-script no script of the page runs (--dump-dom itself needs scripts).
"""
import argparse
import base64
import json
import os
import pathlib
import select
import subprocess
import sys
import tempfile
import time

PATIENCE_S = 60.0


class Pipe:
    """Chromium's protocol: JSON texts ended by a zero byte, in on fd 3, out on fd 4."""

    def __init__(self, profile, width):
        to_browser, self.out = os.pipe()
        self.back, from_browser = os.pipe()
        # The child must find the two at 3 and 4; moved high first, as any of them may be 3 or 4.
        high = [os.dup2(fd, n, inheritable=True) for fd, n in ((to_browser, 63), (from_browser, 64))]
        self.browser = subprocess.Popen(
            ["bash", "-c", 'exec 3<&63 4>&64 63<&- 64>&-; exec chromium "$@"', "bash", "--headless",
             "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
             f"--window-size={width},1400", "--disable-background-networking", "--disable-sync", "--disable-extensions",
             "--remote-debugging-pipe", f"--user-data-dir={profile}"],
            pass_fds=high, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for fd in (to_browser, from_browser, *high):
            os.close(fd)
        self.buffer, self.number, self.events = b"", 0, []

    def send(self, method, session=None, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        return self.number

    def receive(self, until):
        while b"\0" not in self.buffer:
            left = until - time.monotonic()
            if left <= 0 or not select.select([self.back], [], [], left)[0]:
                raise TimeoutError("the browser did not answer in time")
            piece = os.read(self.back, 1 << 16)
            if not piece:
                raise EOFError("the browser went away (is chromium installed?)")
            self.buffer += piece
        text, self.buffer = self.buffer.split(b"\0", 1)
        message = json.loads(text)
        if "method" in message:
            self.events.append(message)
        return message

    def call(self, method, session=None, **parameters):
        number, until = self.send(method, session, **parameters), time.monotonic() + PATIENCE_S
        while True:
            message = self.receive(until)
            if message.get("id") == number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']}")
                return message["result"]

    def wait(self, event):
        until = time.monotonic() + PATIENCE_S
        while not any(e["method"] == event for e in self.events):
            self.receive(until)


def look(pipe, options):
    target = pipe.call("Target.createTarget", url="about:blank")
    session = pipe.call("Target.attachToTarget", targetId=target["targetId"], flatten=True)["sessionId"]
    for domain in ("Page", "Network", "Log", "Runtime", "DOM"):
        pipe.call(f"{domain}.enable", session)
    if options.no_script:
        pipe.call("Emulation.setScriptExecutionDisabled", session, value=True)
    pipe.call("Page.navigate", session, url=pathlib.Path(options.page).resolve().as_uri())
    pipe.wait("Page.loadEventFired")
    root = pipe.call("DOM.getDocument", session, depth=0)["root"]["nodeId"]
    dom = pipe.call("DOM.getOuterHTML", session, nodeId=root)["outerHTML"]
    snapshot = pipe.call("DOMSnapshot.captureSnapshot", session, computedStyles=[])
    strings, layout = snapshot["strings"], snapshot["documents"][0]["layout"]
    text = [strings[i] for i in layout["text"] if i >= 0]
    if options.screenshot:
        shot = pipe.call("Page.captureScreenshot", session, captureBeyondViewport=True)
        pathlib.Path(options.screenshot).write_bytes(base64.b64decode(shot["data"]))
    requests = [e["params"]["request"]["url"] for e in pipe.events
                if e["method"] == "Network.requestWillBeSent"]
    complaints = [e["params"] for e in pipe.events
                  if e["method"] in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded")]
    return {"requests": requests, "complaints": complaints, "dom": dom, "text": text}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--no-script", action="store_true")
    parser.add_argument("--screenshot")
    parser.add_argument("--width", type=int, default=1000)
    parser.add_argument("page")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        pipe = Pipe(profile, options.width)
        try:
            json.dump(look(pipe, options), sys.stdout)
        finally:
            try:
                pipe.send("Browser.close")
            except BrokenPipeError:
                pass  # it is gone already
            try:
                pipe.browser.wait(timeout=10)
            except subprocess.TimeoutExpired:
                pipe.browser.kill()
                pipe.browser.wait()


if __name__ == "__main__":
    main()
