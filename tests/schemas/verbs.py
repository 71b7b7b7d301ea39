"""Every verb of `sixdial` with --json, run against the mock rig; what it prints and exports, as documents."""
import json
import os
import pathlib
import queue
import re
import signal
import socket
import subprocess
import threading
import time

PATIENCE_S = 300.0  # of a busy machine


class Rig:
    """Mock rig and service in a folder of their own; ends both."""

    def __init__(self, source, binaries, folder, speed=20):
        self.source, self.folder = pathlib.Path(source).resolve(), pathlib.Path(folder)
        self.binaries = pathlib.Path(binaries).resolve()
        self.environment = dict(os.environ, XDG_RUNTIME_DIR=str(folder), NO_COLOR="1")
        self.socket = str(self.folder / "s")
        self.started = []
        start = "2026-03-02T08:30:00.000Z"
        mock = self._start("sixdial-mock-rig", "--speed", str(speed), "--start-time", start, "--robot", "table2")
        ready = json.loads(mock.stdout.readline())
        rig = (self.source / "examples/mock/rig.toml").read_text(encoding="utf-8")
        rig = rig.replace("ROBOT_PORT", str(ready["robot_port"])).replace("DIAL_PORT", str(ready["dial_port"]))
        (self.folder / "rig.toml").write_text(rig, encoding="utf-8")
        self._start("sixdiald", "--socket", self.socket, "--db", str(self.folder / "sixdial.db"),
                    "--clock-speed", str(speed), "--clock-start", start)
        self._until(lambda: pathlib.Path(self.socket).is_socket(), "the service's socket")

    def _start(self, program, *words):
        process = subprocess.Popen([self.binaries / program, *words], cwd=self.folder, env=self.environment,
                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.started.append(process)
        return process

    @staticmethod
    def _until(condition, what):
        end = time.monotonic() + PATIENCE_S
        while not condition():
            if time.monotonic() > end:
                raise TimeoutError(f"{what} did not come")
            time.sleep(0.05)

    def close(self):
        for process in reversed(self.started):
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
        for process in self.started:
            process.wait(timeout=30)
            process.stdout.close()

    def command(self, *words):
        return [str(self.binaries / "sixdial"), "--socket", self.socket, "--json", "--quiet", *words]

    def begin(self, *words):
        return subprocess.Popen(self.command(*words), cwd=self.folder, env=self.environment,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def run(self, *words):
        done = subprocess.run(self.command(*words), cwd=self.folder, env=self.environment, capture_output=True,
                              text=True, timeout=PATIENCE_S)
        return parsed(words, done.returncode, done.stdout, done.stderr)

    def ask(self, method, **parameters):
        """One call on the socket; then its lines, answer first."""
        line = socket.socket(socket.AF_UNIX)
        line.settimeout(PATIENCE_S)
        line.connect(self.socket)
        file = line.makefile("rw", encoding="utf-8")
        file.write(json.dumps({"jsonrpc": "2.0", "id": 1, "method": method, "params": parameters}) + "\n")
        file.flush()
        return line, Lines(file)


class Lines:
    """Takes what comes at once, as the service drops who does not read for ten seconds, and keeps it for readline()."""

    def __init__(self, file):
        self.lines = queue.Queue()
        threading.Thread(target=self._take, args=(file,), daemon=True).start()

    def _take(self, file):
        try:
            for line in file:
                self.lines.put(line)
        except (OSError, ValueError):  # closed here, or nothing came for too long
            pass
        self.lines.put("")  # the end

    def readline(self):
        return self.lines.get(timeout=PATIENCE_S)


def parsed(words, code, out, err):
    lines = out.splitlines()
    if len(lines) != 1:
        raise SystemExit(f"sixdial --json {' '.join(words)}: {len(lines)} lines on stdout, one expected; "
                         f"exit {code}, stderr:\n{err}")
    return code, json.loads(lines[0])


def verbs_of(binaries):
    """Every command that the man page has: "session list", "collect", ..."""
    page = subprocess.run([pathlib.Path(binaries) / "sixdial", "manual"], capture_output=True, text=True, check=True).stdout
    page = page.replace("\\-", "-")  # as roff writes it
    return set(re.findall(r"^\.SS sixdial (.*)$", page, re.M))


def quick(*words):
    return (*words, "--particles", "8", "--qpso1-iterations", "3", "--qpso2-iterations", "5", "--anfis-epochs", "5")


def documents(rig):
    """Yields (verb or file, document); a verb may come more than once."""
    bundle = str(rig.source / "tests/data/sessions/01")
    folder = rig.folder
    said = {}

    def run(verb, *words, code=0):
        got, document = rig.run(*verb.split(), *words)
        if got != code:
            raise SystemExit(f"sixdial --json {verb} {' '.join(words)}: exit {got}, {code} expected: {document}")
        said[verb] = document
        return verb, document

    def file_of(name):
        return name, json.loads((folder / name).read_text(encoding="utf-8"))

    yield run("hello")
    yield run("protocol")
    yield run("completion")
    yield run("manual")
    yield run("doctor", "--db", str(folder / "sixdial.db"), "--rig", "rig.toml", "--by-id", str(folder))
    yield run("rig scan", "--rig", "rig.toml", "--no-search")
    yield run("rig scan", "--rig", "rig.toml", "--by-id", str(folder))
    yield run("rig draw", "rig.toml")
    yield run("rig draw", "rig.toml", "-o", "rig.svg")
    # Collecting, with every key of the collector as a verb.
    yield run("plan random", "--rig", "rig.toml", "--count", "12", "--seed", "1")
    yield run("plan grid", "--rig", "rig.toml", "--nx", "3", "--ny", "3", "-o", "grid.csv")
    yield run("plan random", "--rig", "rig.toml", "--count", "40", "--seed", "1", "-o", "g1.csv")
    yield run("plan random", "--rig", "rig.toml", "--count", "8", "--seed", "2", "--set", "G2", "-o", "g2.csv")
    g1 = (folder / "g1.csv").read_text(encoding="utf-8")
    g2 = (folder / "g2.csv").read_text(encoding="utf-8")
    (folder / "plan.csv").write_text(g1 + g2.split("\n", 1)[1], encoding="utf-8")
    yield run("session create", "monday", "--rig", "rig.toml")
    yield run("session show", "monday")
    yield run("dials", "--rig", "rig.toml")
    yield run("dials", "monday")
    yield run("robot stop", "monday")
    yield run("collection status")
    line, events = rig.ask("events.subscribe", topics=[])
    yield "events.subscribe", json.loads(events.readline())
    collecting = rig.begin("collect", "plan.csv", "--session", "monday")
    seen = {}
    while not {"live", "sample", "collect"} <= set(seen):
        event = json.loads(events.readline())
        topic = event["params"].get("topic", "gap")
        seen[topic] = event
        yield "event", event
    yield run("collection pause")
    yield run("collection resume")
    yield run("collection retake")
    for key in ("skip", "accept", "moved"):  # right or wrong now: an answer either way
        code, document = rig.run("collection", key)
        if code not in (0, 1):
            raise SystemExit(f"collection {key}: exit {code}")
        said[f"collection {key}"] = document
        yield f"collection {key}", document
    watching = rig.begin("collection", "watch")
    yield run("collection status")
    yield run("collection stop")
    for verb, process in (("collect", collecting), ("collection watch", watching)):
        out, err = process.communicate(timeout=PATIENCE_S)
        said[verb] = parsed((verb,), process.returncode, out, err)[1]
        yield verb, said[verb]
    yield run("collect", "--session", "monday")  # goes on where it stopped
    yield run("session undo", "monday")
    yield run("session show", "monday", "--limit", "3")
    yield run("session export", "monday", "monday-bundle")
    yield run("session import", bundle, "--name", "tuesday")
    yield run("session list")
    # Results.
    yield run("calibrate", *quick("monday", "-o", "calibration.json"))
    yield file_of("calibration.json")
    yield run("calibrate", *quick("tuesday"))
    yield run("rig adopt", "tuesday", "--rig", "rig.toml", "-o", "adopted.toml")
    yield run("calibrate", *quick(bundle))
    # One job topic event at least, of the calibrations above.
    while "job" not in seen:
        event = json.loads(events.readline())
        topic = event["params"].get("topic", "gap")
        seen[topic] = event
        yield "event", event
    line.shutdown(socket.SHUT_RDWR)
    line.close()
    yield run("compare", *quick("tuesday", "--bpnn-epochs", "5", "-o", "comparison.json"))
    yield file_of("comparison.json")
    yield run("compare", "tuesday", "--methods", "before,lm", "--space", "dials", "-o", "by_dials.json")
    yield "comparison.json", json.loads((folder / "by_dials.json").read_text(encoding="utf-8"))
    yield run("diagnose", "tuesday", "--bootstrap", "0", "-o", "diagnosis.json", "--report", "page.html")
    yield file_of("diagnosis.json")
    yield run("diagnose", bundle, "--bootstrap", "0", "--no-gain")
    (folder / "axis.toml").write_text(
        'name = "one axis"\n[robot]\nmodel = "serial"\n[[joint]]\na_mm = 100\n', encoding="utf-8")
    (folder / "axis_map.toml").write_text(
        'rig = "axis.toml"\n' + "".join(
            f'[[column]]\nfrom = "{a}"\nto = "{b}"\n' for a, b in
            (("q", "q1_rad"), ("x", "x_mm"), ("y", "y_mm"), ("z", "z_mm"))), encoding="utf-8")
    (folder / "axis.csv").write_text("q;x;y;z\n0,1;99,5;10;0\n0,2;98;20;0\n", encoding="utf-8")
    yield run("import", "axis.csv", "--map", "axis_map.toml", "-o", "axis")
    yield run("plan next", "tuesday", "--points", "3")
    yield run("plan rig-check", "--rig", "rig.toml", "--points", "3")
    arm = str(rig.source / "examples/sockets/arm.toml")
    yield run("plan sockets", "--rig", arm, "--at", "260", "-90", "40", "--at", "260", "90", "40", "--count", "4")
    yield run("plan separate", bundle, "--points", "3", "-o", "separate.csv")
    yield run("recommend", "tuesday", "-o", "recommendation.json")
    yield file_of("recommendation.json")
    yield run("compensate", "tuesday", "--target", "28,45")
    yield run("compensate", "tuesday", "--target", "28,45", "--model", "extended")
    yield run("compensate", "tuesday", "--plan", "grid.csv")
    yield run("compensate", "tuesday", "--plan", "grid.csv", "-o", "commanded.csv")
    yield run("export-model", "tuesday", "--as", "c")
    yield run("export-model", "tuesday", "--as", "json", "--model", "extended", "-o", "robot.json")
    yield file_of("robot.json")
    yield run("export-model", bundle, "--as", "json", "--calibration-method", "lm+gp", "-o", "robot_gp.json")
    yield "robot.json", json.loads((folder / "robot_gp.json").read_text(encoding="utf-8"))
    yield run("validate", "monday", "--method", "before,full", "-o", "validation.json")
    yield file_of("validation.json")
    yield run("report", "tuesday", "--against", "monday", "-o", "report")
    for name in ("report", "calibration", "comparison", "diagnosis", "recommendation"):
        yield file_of(f"report/{name}.json")
    yield run("job list")
    yield run("job status", "1")
    yield run("job wait", "1")
    yield run("job cancel", "1")
    code, document = rig.run("session", "show", "nobody")
    yield "error", document
    code, document = rig.run("calibrate", str(folder / "nowhere") + "/")
    yield "error", document
    yield run("shutdown")
    missing = verbs_of(rig.binaries) - set(said)
    if missing:
        raise SystemExit(f"commands that no document was asked of, add them here: {sorted(missing)}")
