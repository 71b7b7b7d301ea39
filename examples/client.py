#!/usr/bin/env python3
"""sixdiald by the standard library: client.py METHOD [key=value ...], e.g. client.py session.show
session=demo limit=5, or client.py events.subscribe topics='["job"]' (until Ctrl-C)."""
import json, os, socket, sys

class Sixdial:
    def __init__(self):
        self.last_id, self.socket = 0, socket.socket(socket.AF_UNIX)
        self.socket.connect(os.environ.get("SIXDIAL_SOCKET") or os.path.join(
            os.environ.get("XDG_RUNTIME_DIR", "/run"), "sixdial", "sixdiald.sock"))
        self.lines, self.events = self.socket.makefile("r", encoding="utf-8"), []
    def call(self, method, **params):
        self.last_id += 1
        request = {"jsonrpc": "2.0", "id": self.last_id, "method": method, "params": params}
        self.socket.sendall(json.dumps(request).encode() + b"\n")
        for reply in map(json.loads, self.lines):
            if reply.get("id") != self.last_id: self.events.append(reply)  # came in between
            elif "result" in reply: return reply["result"]
            else: sys.exit("{message} ({data[hint]})".format(**reply["error"]))
        sys.exit("the service has gone")

def value(text):
    try: return json.loads(text)
    except ValueError: return text
if __name__ == "__main__":
    client, words = Sixdial(), dict(word.split("=", 1) for word in sys.argv[2:])
    print(json.dumps(client.call(sys.argv[1], **{key: value(text) for key, text in words.items()})))
    for line in client.lines if sys.argv[1] == "events.subscribe" else []:
        print(line, end="", flush=True)
