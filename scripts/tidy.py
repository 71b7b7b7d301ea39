#!/usr/bin/env python3
"""clang-tidy over many sources, several of one folder read as one.

Most of clang-tidy's time goes into the headers of others, which every source includes anew: ten to eighteen
seconds a source alone, two to three in company. Sources that define a name twice at the outermost level are
kept apart; if a group does not compile, its sources are read one by one.

  scripts/tidy.py [--seconds N] SOURCE ...   in this order; after N seconds no further group is begun

What was read clean is kept in build/check/tidy/clean, under a hash of all that clang-tidy would read: a second
run reads only what has changed since, and a run that was stopped goes on. Needs
build/check/compile_commands.json (scripts/check.sh makes it). Ends with 1 if there is a finding.
"""
import argparse
import bisect
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / "check"
MOST_TOGETHER = 10
# Version 16 knows C++20's coroutines, but Boost 1.74 does not know that it does.
TIDY = ["clang-tidy-16", "--quiet", "--extra-arg=-DBOOST_ASIO_HAS_CO_AWAIT=1",
        "--extra-arg=-DBOOST_ASIO_HAS_STD_COROUTINE=1"]
TIDY_VERSION = subprocess.run([TIDY[0], "--version"], capture_output=True, text=True).stdout
# The flags are its own.
COMPILER = "g++"
# Lines at the outermost level that define no name, or one that is overloaded.
UNNAMED = r"(namespace|using|extern|template|TEST|TEST_F|TEST_P|INSTANTIATE_TEST_SUITE_P|Json to_json|void describe_keys)\b"
# Compiles itself once for every kind of processor.
ALONE = re.compile(r"HWY_TARGET_INCLUDE|^#define|^#undef", re.MULTILINE)


def compile_flags():
    """Of each source: its compiler's arguments without input, output and -c."""
    flags = {}
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])[1:]
        kept = []
        skip = False
        for word in words:
            # The last one is GCC's alone.
            if skip or word in ("-c", "-fpch-preprocess", entry["file"], "-Wno-stringop-overflow"):
                skip = False
            elif word == "-o":
                skip = True
            else:
                kept.append(word)
        flags.setdefault(os.path.relpath(entry["file"], ROOT), tuple(kept))
    return flags


def names_at_top(text):
    """What a source defines outside of any type or function: clang-format leaves it unindented."""
    names = set()
    for line in text.splitlines():
        if not line or line[0] in " }#/" or re.match(UNNAMED, line):
            continue
        found = (re.match(r"(?:struct|class|enum(?: class)?) (\w+)", line) or
                 re.search(r"([\w:~]+)(?:\[\])?\s*(?:[({=;]|$)", line))
        if found and "::" not in found.group(1):  # not a member's definition
            names.add(found.group(1))
    return names


def groups_of(sources, flags):
    """Lists of sources of one folder that can be read as one, the first source's place in the order kept."""
    groups = []
    is_open = {}
    for source in sources:
        text = (ROOT / source).read_text()
        if ALONE.search(text):
            groups.append([source])
            continue
        names = names_at_top(text)
        key = (source.split("/")[0] if not source.startswith("tests/") else os.path.dirname(source), flags[source])
        for group, taken in is_open.setdefault(key, []):
            if len(group) < MOST_TOGETHER and not names & taken:
                group.append(source)
                taken |= names
                break
        else:
            group = [source]
            groups.append(group)
            is_open[key].append((group, names))
    return groups


def is_clean_file(path, flags, less):
    """Where it is kept that this source was read without a finding; None if its headers cannot be read."""
    # Comments too: one can silence a check. And macros have checks of their own: the source as it stands.
    # Some macros of libraries cannot be expanded with the comments in them.
    for comments in ("-CC", "-C"):
        read = subprocess.run([COMPILER, "-E", "-dD", comments, "-P", "-w",
                               *(f for f in flags if not f.startswith("-W")), str(path)],
                              capture_output=True, cwd=BUILD)
        if read.returncode == 0:
            break
    if read.returncode:
        return None
    key = hashlib.sha256()
    for part in (read.stdout, path.read_bytes(), (ROOT / ".clang-tidy").read_bytes(),
                 "\0".join([TIDY_VERSION, *TIDY, *less, *flags]).encode()):
        key.update(hashlib.sha256(part).digest())
    return BUILD / "tidy" / "clean" / key.hexdigest()


def run_tidy(path, flags, source):
    # The analyser follows every path, half of the time; tests run theirs, under sanitizers too.
    less = ["--checks=-clang-analyzer-*"] if source.startswith("tests/") else []
    clean = is_clean_file(pathlib.Path(path), flags, less)
    if clean and clean.exists():
        return 0, "", ""
    done = subprocess.run(TIDY + less + [f"--config-file={ROOT / '.clang-tidy'}", str(path), "--", *flags],
                          capture_output=True, text=True, cwd=BUILD)
    complete = done.returncode == 1 and "clang-diagnostic-error" not in done.stdout
    if complete and done.stdout and not own_findings(done.stdout):
        done.returncode = 0
    if clean and done.returncode == 0:
        clean.touch()
    return done.returncode, done.stdout, done.stderr


def own_findings(text):
    """One by one, without those inside of libraries: the analyser follows calls into them and doubts their code.

    And without shadowed names: in company they are another source's, and every build asks g++ for them (-Wshadow).
    """
    parts = re.split(r"(?m)^(?=\S+:\d+:\d+: (?:error|warning): )", text)
    return [part for part in parts
            if part.strip() and not part.startswith("/usr/") and "[clang-diagnostic-shadow" not in part]


def read_group(group, flags):
    """The findings in a group of sources; each as text."""
    if len(group) > 1:
        begins, lines = [], []
        for source in group:
            begins.append(len(lines) + 1)
            lines += (ROOT / source).read_text().splitlines()
        path = BUILD / "tidy" / ("from_" + group[0].replace("/", "__"))
        path.write_text("\n".join(lines) + "\n")
        # A header beside a source; not as -I, or diagnosis/limits.h would be <limits.h>.
        folders = sorted({str((ROOT / source).parent) for source in group})
        code, out, err = run_tidy(path, [*flags[group[0]], *(f"-iquote{f}" for f in folders)], group[0])

        def place(match):
            line = int(match.group(1))
            which = bisect.bisect_right(begins, line) - 1
            return f"{ROOT / group[which]}:{line - begins[which] + 1}:"

        if "clang-diagnostic-error" not in out:
            return [re.sub(re.escape(str(path)) + r":(\d+):", place, out or err)] if code else []
        print(f"   read one by one: {' '.join(group)}", flush=True)
        if os.environ.get("SIXDIAL_TIDY_WHY"):
            print("\n".join(l for l in out.splitlines() if "clang-diagnostic-error" in l))
    findings = []
    for source in group:
        code, out, err = run_tidy(ROOT / source, flags[source], source)
        if code:
            findings.append(out or err)
    return findings


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=float("inf"))
    parser.add_argument("sources", nargs="+")
    given = parser.parse_args()
    (BUILD / "tidy" / "clean").mkdir(parents=True, exist_ok=True)
    flags = compile_flags()
    sources = [source for source in given.sources if source in flags]
    for source in set(given.sources) - set(sources):
        print(f"   not in this build: {source}")
    groups = groups_of(sources, flags)
    started = time.monotonic()
    read = 0
    seen = set()

    def work(number):
        if time.monotonic() - started > given.seconds:
            return None
        begun = time.monotonic()
        return read_group(groups[number], flags), time.monotonic() - begun

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for group, result in zip(groups, pool.map(work, range(len(groups)))):
            if result is None:
                continue
            read += len(group)
            if os.environ.get("SIXDIAL_TIDY_WHY"):
                print(f"   {result[1]:6.1f} s  {len(group):2d}  {group[0]}", flush=True)
            for text in result[0]:
                # A header's finding is told by every group that includes it.
                for part in own_findings(text):
                    if part not in seen:
                        seen.add(part)
                        print(part, flush=True)
    took = time.monotonic() - started
    print(f"   {read} of {len(sources)} sources read as {len(groups)} in {took:.0f} s")
    return 1 if seen else 0


if __name__ == "__main__":
    sys.exit(main())
