#!/usr/bin/env python3
"""Tries CONTRIBUTING.md: its commands and files exist, and "Add a dial" works as it is written.

how_to_test.py commands SOURCE_DIR             every command and path that the page names exists
how_to_test.py add_a_dial SOURCE_DIR WORK_DIR  follows "Add a dial" in a copy of the tree, builds,
                                               and runs the laws of every dial on the new one
"""
import os
import re
import shutil
import subprocess
import sys


def fail(text):
    sys.exit("how_to_test: " + text)


def commands(source):
    page = open(os.path.join(source, "CONTRIBUTING.md"), encoding="utf-8").read()
    usage = subprocess.run([os.path.join(source, "run"), "help"], capture_output=True, text=True,
                           check=True).stdout
    verbs = set(re.findall(r"^\./run (\w+)", usage, re.M))
    named = set(re.findall(r"\./run (\w+)", page))
    if len(named) < 4:
        fail("CONTRIBUTING.md names almost no command; is the pattern still right?")
    for verb in sorted(named - verbs):
        fail(f"CONTRIBUTING.md says './run {verb}', which './run help' does not know")
    presets = subprocess.run(["cmake", "--list-presets=workflow"], cwd=source, capture_output=True,
                             text=True, check=True).stdout
    for preset in re.findall(r"--preset (\w+)", page):
        if f'"{preset}"' not in presets:
            fail(f"CONTRIBUTING.md names the preset '{preset}', which CMakePresets.json has not")
    paths = set(re.findall(r"`([a-z_]+/[a-z_/]*\.(?:cpp|h|md|py|txt|sh))`", page))
    paths |= set(re.findall(r"\]\(([\w/.]+)\)", page))
    if len(paths) < 8:
        fail("CONTRIBUTING.md names almost no file; is the pattern still right?")
    for path in sorted(paths):
        if not os.path.exists(os.path.join(source, path)):
            fail(f"CONTRIBUTING.md names '{path}', which does not exist")
    print(f"{len(named)} commands and {len(paths)} paths of CONTRIBUTING.md exist")


def put(tree, path, old, new):
    name = os.path.join(tree, path)
    text = open(name, encoding="utf-8").read()
    if old not in text:
        fail(f"{path}: the how-to's place is gone: {old!r}")
    open(name, "w", encoding="utf-8").write(text.replace(old, new, 1))


def add_a_dial(source, work):
    source, work = os.path.abspath(source), os.path.abspath(work)
    tree = os.path.join(work, "tree")
    shutil.rmtree(work, ignore_errors=True)
    shutil.copytree(source, tree, ignore=shutil.ignore_patterns("build*", ".git", "out", "node_modules"))
    example = os.path.join(source, "tests/howto/add_a_dial")
    # Steps 1 and 2: parser and its line.
    shutil.copy(os.path.join(example, "acquisition_plain.cpp"),
                os.path.join(tree, "acquisition/dials/plain.cpp"))
    put(tree, "acquisition/dial_protocol.cpp", "extern const DialProtocol mw;",
        "extern const DialProtocol mw;\nextern const DialProtocol plain;")
    put(tree, "acquisition/dial_protocol.cpp", "&mux10, &mw}", "&mux10, &mw, &plain}")
    # Step 3: the twin and its line.
    shutil.copy(os.path.join(example, "mock_plain.cpp"),
                os.path.join(tree, "mock_devices/dials/plain.cpp"))
    put(tree, "mock_devices/dials/dialect.h", "extern const Dialect kMw;",
        "extern const Dialect kMw;\nextern const Dialect kPlain;")
    put(tree, "mock_devices/dials/dialect.cpp", "*, 5> all{&kSylvac, &kMahr, &kMux10, &kMw,",
        "*, 6> all{&kPlain, &kSylvac, &kMahr, &kMux10, &kMw,")
    # Step 4: the maker's frame.
    put(tree, "tests/acquisition/every_dial_test.cpp", '  if (dialect == "mahr")',
        '  if (dialect == "plain") return fmt::format("{}{:07.3f}\\r", sign, size);\n'
        '  if (dialect == "mahr")')
    build = os.path.join(tree, "build/release")
    # Only the acquisition's tests: the others are not what is being added to.
    for folder in os.listdir(os.path.join(tree, "tests")):
        keep = folder in ("acquisition", "support", "data", "peers")
        if not keep and os.path.isdir(os.path.join(tree, "tests", folder)):
            shutil.rmtree(os.path.join(tree, "tests", folder))
    run = lambda *command: subprocess.run(command, cwd=tree, check=True)
    run("cmake", "--preset", "release", "-DSIXDIAL_BENCH=OFF", "-DSIXDIAL_REPORT_CHARTS=OFF",
        "-DSIXDIAL_TESTS=ON")
    run("cmake", "--build", build, "--target", "test_acquisition", "sixdial_mock_devices")
    laws = subprocess.run([os.path.join(build, "bin/test_acquisition"),
                           "--gtest_filter=*EveryDial*plain*"], capture_output=True, text=True)
    print(laws.stdout[-2000:])
    if laws.returncode != 0 or not re.search(r"\[  PASSED  \] [1-9]\d* tests?", laws.stdout):
        fail("the laws of every dial were not passed by the new one")
    shutil.rmtree(work, ignore_errors=True)


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "commands":
        commands(sys.argv[2])
    elif len(sys.argv) == 4 and sys.argv[1] == "add_a_dial":
        add_a_dial(sys.argv[2], sys.argv[3])
    else:
        fail(__doc__)
