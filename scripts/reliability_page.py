#!/usr/bin/env python3
"""doc/reliability.md from the logs of scripts/reliability.sh: LOGS COMMAND SECONDS FUZZED"""
import glob, re, sys

logs, command, seconds, fuzzed = sys.argv[1:5]
figures, faults = {}, []
for path in sorted(glob.glob(logs + "/*.log")):
    for line in open(path, errors="replace"):
        if line.startswith("FIGURE "):
            _, name, value = line.split()
            figures[name] = float(value)
        elif line.startswith("FAULT "):
            faults.append(line[6:].rstrip("\n").split("|"))

def f(name, digits=0):
    if name not in figures:
        sys.exit(f"reliability_page: the runs gave no figure '{name}'")
    return f"{figures[name]:,.{digits}f}"

def table(titles, rows):
    print("| " + " | ".join(titles) + " |\n|" + "---|" * len(titles))
    for row in rows:
        print("| " + " | ".join(str(cell).replace("|", "/") for cell in row) + " |")
    print()

print("# What it withstood\n")
print("<!-- Written by scripts/reliability.sh from its runs; do not edit. -->\n")
print(f"Made by `{command.strip()}` in {int(seconds)} s, on a machine shared with other work. Each line is a test of the"
      "\nordinary suite, run here at a larger size; `scripts/reliability.sh --help` says how to choose it and what the"
      " full run is.\n")
print("## Store\n")
table(["what", "how often", "acknowledged samples lost", "integrity failures", "test"], [
    ["kill -9 at a random moment, also while opening and migrating", f("crash.runs") + " ("
     + f("crash.samples_acknowledged") + " samples acknowledged)", f("crash.samples_lost"),
     f("crash.integrity_failures"), "`StoreFile.LosesNoAcknowledgedSampleToKill9`"],
    [f"every one of the {f('sweep.operations')} writes, syncs and truncations of a session fails: once, torn, for ever, no room",
     f("sweep.fault_points"), f("sweep.samples_lost"), f("sweep.integrity_failures"), "`StoreFaults.EveryWriteSync...`"],
    ["power lost at each of them; sectors that were not synced gone, kept or mixed", f("power.losses"),
     f("power.samples_lost"), f("power.integrity_failures"), "`StoreFaults.PowerMayGo...`"]])
print(f"Of the {f('sweep.fault_points')} failures {f('sweep.told_at_once')} were told to the caller at once, in words and with a hint; the\n"
      "others hit the checkpoint at closing, when all is acknowledged and safe in the log. After a failed write or sync nothing more is stored until the service\n"
      "starts again; a full disk goes on when there is room. The power test was once tried with\n"
      f"`synchronous=NORMAL` instead of `FULL`, and failed as it must. Stored databases of {f('migration.schemas')} earlier schemas (`tests/data/schemas/`) come up with all they had.\n")
print("## Devices\n")
print(f"All {f('faults.orderable')} faults of the mock rig, ordered for one dial after the first point of a collection. Noticed: from the\n"
      "order until the board shows it. Recovery: from the end of the fault until a good reading that was asked for after\n"
      "it. At the rig's own speed; a dash: only a moved robot, or nothing, shows it.\n")
def told(text):  # of the faulty dial; the others of its box say the same
    text = re.sub(r"/\S*/ptys/", "/dev/", text)
    return text.split("; dial B")[0].removesuffix(", ")
def ms(a, b):
    return "-" if float(a) == 0 and float(b) == 0 else f"{float(a):.0f} / {float(b):.0f}"
table(["fault", "cable", "stored", "reason", "what the operator sees", "noticed [ms] median / 99 %", "recovery [ms] median / 99 %"],
      [[x[0], x[1], x[2], x[3], told(x[4]), ms(x[5], x[6]), ms(x[7], x[8])] for x in faults])
print(f"{f('faults.recoveries')} recoveries in all: median {f('faults.recovery_median_ms')} ms, 99 % {f('faults.recovery_p99_ms')} ms. After a time-out the line is left alone"
      "\nfor longer than the slowest device answers (1 s), so that a late reply ends up on no other dial. Unplugged was told\n"
      f"from silent after {f('unplugged.noticed_ms', 1)} ms, with {f('unplugged.processor_percent', 1)} % of a processor.\n")
print("### Throughput\n")
table(["cable", "scans of six a second", "first to last request of a sample [ms]"],
      [[k, f(f"throughput.{k}.scans_per_s", 1), f(f"throughput.{k}.spread_ms", 1)]
       for k in ("modbus-tcp", "modbus_rtu", "sylvac", "mahr", "mux10", "mw")])
print("On Modbus all six come from one request; six cables are asked at once; behind a multiplexer one after the other, and\n"
      "each reading keeps its own time.\n")
print("## Service\n")
table(["what", "figure"], [
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
print("## Fuzzing\n")
names = sorted({n.split(".")[1] for n in figures if n.startswith("fuzz.")})
if names:
    table(["libFuzzer program (address, undefined)", "executions", "findings"],
          [[f"`{n}`", f(f"fuzz.{n}.executions"), f(f"fuzz.{n}.findings")] for n in names])
else:
    print(f"libFuzzer: {fuzzed}.\n")
total = sum(v for n, v in figures.items() if n.startswith("corpus."))
print(f"In the suite (`test_fuzz`): the kept corpus and {total:,.0f} seeded mutations of it. A first finding of it, a number too large for\n"
      "a double that was answered as an internal fault, is now a parse error, and in the corpus.\n")
if "package.bytes" in figures:
    print("## Package\n")
    rows = [["files installed", f("package.files")], ["size of the .deb [bytes]", f("package.bytes")]]
    if "package.lintian_errors" in figures:
        rows += [["lintian: errors, warnings", f("package.lintian_errors") + ", " + f("package.lintian_warnings")]]
    table(["what", "figure"], rows)
