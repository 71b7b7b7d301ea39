#!/usr/bin/env python3
"""doc/reliability.md from the logs of scripts/reliability.sh: LOGS PAGE. A part without logs keeps its section of PAGE."""
import glob, os, re, sys

logs, page = sys.argv[1:3]
PARTS = ("store", "devices", "service", "fuzz", "package")


class Part:
    """What the newest run of one part gave."""

    def __init__(self, name):
        self.name, self.figures, self.faults, self.lines = name, {}, [], []
        with open(f"{logs}/{name}/about") as about:
            self.about = dict(line.rstrip("\n").split("=", 1) for line in about)
        for path in sorted(glob.glob(f"{logs}/{name}/*.log")):
            for line in open(path, errors="replace"):
                if line.startswith("FIGURE "):
                    _, key, value = line.split()
                    self.figures[key] = float(value)
                elif line.startswith("FAULT "):
                    self.faults.append(line[6:].rstrip("\n").split("|"))

    def f(self, key, digits=0):
        if key not in self.figures:
            sys.exit(f"reliability_page: the run of {self.name} gave no figure '{key}'")
        return f"{self.figures[key]:,.{digits}f}"

    def say(self, text):
        self.lines.append(text + "\n")

    def table(self, titles, rows):
        lines = ["| " + " | ".join(titles) + " |", "|" + "---|" * len(titles)]
        lines += ["| " + " | ".join(str(cell).replace("|", "/") for cell in row) + " |" for row in rows]
        self.say("\n".join(lines))

    def heading(self, title):
        a = self.about
        self.say(f"## {title}")
        self.say(f"`{a['command']}`, {a['date']}, commit {a['commit']}, {int(a['seconds']):,} s.")


def store(p):
    f = p.f
    p.heading("Store")
    p.table(["what", "how often", "acknowledged samples lost", "integrity failures", "test"], [
        ["kill -9 at a random moment, also while opening and migrating", f("crash.runs") + " ("
         + f("crash.samples_acknowledged") + " samples acknowledged)", f("crash.samples_lost"),
         f("crash.integrity_failures"), "`StoreFile.LosesNoAcknowledgedSampleToKill9`"],
        [f"every one of the {f('sweep.operations')} writes, syncs and truncations of a session fails: once, torn, for ever, no room",
         f("sweep.fault_points"), f("sweep.samples_lost"), f("sweep.integrity_failures"), "`StoreFaults.EveryWriteSync...`"],
        ["power lost at each of them; sectors that were not synced gone, kept or mixed", f("power.losses"),
         f("power.samples_lost"), f("power.integrity_failures"), "`StoreFaults.PowerMayGo...`"]])
    p.say(f"Of the {f('sweep.fault_points')} failures {f('sweep.told_at_once')} were told to the caller at once, in words and with a hint; the\n"
          "others hit the checkpoint at closing, when all is acknowledged and safe in the log. After a failed write or sync nothing more is stored until the service\n"
          "starts again; a full disk goes on when there is room. The power test was once tried with\n"
          f"`synchronous=NORMAL` instead of `FULL`, and failed as it must. Stored databases of {f('migration.schemas')} earlier schemas (`tests/data/schemas/`) come up with all they had.\n"
          f"One kill with start, check and comparison takes {f('crash.ms_a_kill', 1)} ms.")


def devices(p):
    f = p.f
    p.heading("Devices")
    p.say(f"All {f('faults.orderable')} faults of the mock rig, ordered for one dial in the middle of a collection, on each cable that can\n"
          "show them; each of the six dials has its turn. Noticed: from the order until the board shows it. Recovery: from the\n"
          "end of the fault until a good reading that was asked for after it. At the rig's own speed; a dash: only a moved robot,\n"
          "or nothing, shows it.")

    def told(text):  # of the faulty dial; the others of its box say the same
        text = re.sub(r"/\S*/ptys/", "/dev/", text)
        return text.split("; dial ")[0].removesuffix(", ")

    def ms(a, b):
        return "-" if float(a) == 0 and float(b) == 0 else f"{float(a):.0f} / {float(b):.0f}"

    p.table(["fault", "cable", "dial", "stored", "reason", "what the operator sees", "noticed [ms] median / 99 %", "recovery [ms] median / 99 %"],
            [[x[0], x[1], x[2], x[3], x[4], told(x[5]), ms(x[6], x[7]), ms(x[8], x[9])] for x in p.faults])
    p.say(f"{f('faults.recoveries')} recoveries in all: median {f('faults.recovery_median_ms')} ms, 99 % {f('faults.recovery_p99_ms')} ms. After a time-out the line is left alone"
          "\nfor longer than the slowest device answers (1 s), so that a late reply ends up on no other dial. Unplugged was told\n"
          f"from silent after {f('unplugged.noticed_ms', 1)} ms, with {f('unplugged.processor_percent', 1)} % of a processor.")
    p.say("### Throughput")
    cables = [("modbus-tcp", "-"), ("modbus_rtu_115200", "115200"), ("modbus_rtu", "19200"), ("sylvac", "4800"), ("mahr", "9600"),
              ("mux10", "9600"), ("mw", "9600")]
    p.table(["cable", "baud", "scans of six a second", "first to last request of a sample [ms]"],
            [[k.removesuffix("_115200"), baud, f(f"throughput.{k}.scans_per_s", 1), f(f"throughput.{k}.spread_ms", 1)] for k, baud in cables])
    p.say("On Modbus all six come from one request; six cables are asked at once; behind a multiplexer one after the other, and\n"
          "each reading keeps its own time. `sixdial session show` and the report say how far apart the six of a sample were.")


def service(p):
    f = p.f
    p.heading("Service")
    p.table(["what", "figure"], [
        ["clients at once", f("load.clients")],
        ["requests a second while a session is collected", f("load.requests_per_s")],
        ["requests in all, lost", f("load.requests") + ", " + f("load.requests_lost")],
        ["answered within (median, 99 %) [ms]", f("load.latency_median_ms", 2) + ", " + f("load.latency_p99_ms", 2)],
        ["samples stored meanwhile", f("load.samples")],
        ["age of a sample's oldest reading when it is stamped (median, worst) [ms]",
         f("load.reading_age_median_ms", 1) + ", " + f("load.reading_age_worst_ms", 1)],
        ["from sample to sample without and with that load (median) [ms]",
         f("load.interval_calm_ms") + ", " + f("load.interval_ms")],
        ["samples late by more than one scan (20 ms)", f("load.samples_late_by_more_than_a_scan")],
        ["hours of the rig's time in the soak, samples", f("soak.rig_hours", 1) + ", " + f("soak.samples")],
        ["growth over the last two thirds: memory [MB], descriptors",
         f("soak.memory_growth_mb", 1) + ", " + f("soak.descriptor_growth")],
        ["end after SIGTERM [s]", f("service.shutdown_s", 3)]])


def fuzz(p):
    f = p.f
    p.heading("Fuzzing")
    names = sorted({n.split(".")[1] for n in p.figures if n.startswith("fuzz.")})
    p.table(["libFuzzer program (address, undefined)", "executions", "findings"],
            [[f"`{n}`", f(f"fuzz.{n}.executions"), f(f"fuzz.{n}.findings")] for n in names])
    total = sum(v for n, v in p.figures.items() if n.startswith("corpus."))
    p.say(f"In the suite (`test_fuzz`): the kept corpus and {total:,.0f} seeded mutations of it; it has a valid input for every dialect,\n"
          "register format, session, plan and rig file, so that the code behind each parser is reached. A first finding of it, a number too\n"
          "large for a double that was answered as an internal fault, is now a parse error, and in the corpus. So are two texts on which\n"
          "toml++ 3.3 runs into undefined behaviour (a character beyond ASCII after a backslash, or after a quote inside of a word): they are\n"
          "refused before it sees them (2026-11-22: found in ten minutes of `session_rig_fuzz`, which mended ran 400 s more; its line is that run).")


def package(p):
    f = p.f
    p.heading("Package")
    rows = [["files installed", f("package.files")], ["size of the .deb [bytes]", f("package.bytes")]]
    for key, what, digits in [
            ("package.lintian_errors", "lintian: errors", 0), ("package.lintian_warnings", "lintian: warnings", 0),
            ("package.exposure", "`systemd-analyze security` of the unit: exposure, 10 is worst", 1),
            ("trial.checks", "checks of `scripts/package_trial.sh` (installed, used in and outside the group, purged)", 0),
            ("trial.samples", "samples collected by the installed programs", 0),
            ("trial.left", "files left after the purge (the database, as promised)", 0)]:
        if key in p.figures:
            rows.append([what, f(key, digits)])
    p.table(["what", "figure"], rows)


sections = {}
if os.path.exists(page):
    with open(page) as old:
        for name, text in re.findall(r"<!-- part (\w+) -->\n(.*?)(?=<!-- part |\Z)", old.read(), re.S):
            sections[name] = text.strip("\n") + "\n"
for name in PARTS:
    if os.path.exists(f"{logs}/{name}/about"):
        part = Part(name)
        globals()[name](part)
        sections[name] = "\n".join(part.lines)
    elif name not in sections:
        sections[name] = f"## {name.capitalize()}\n\nNot run yet: `scripts/reliability.sh --only {name}`.\n"
print("# What it withstood\n")
print("<!-- Written by scripts/reliability.sh from its runs; do not edit. -->\n")
print("Each line is a test of the ordinary suite, run here at a larger size on a machine shared with other work, by the\n"
      "command that stands below each heading; `scripts/reliability.sh --help` says what the full run is.\n")
print("\n".join(f"<!-- part {name} -->\n{sections[name]}" for name in PARTS), end="")
