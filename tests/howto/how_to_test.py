#!/usr/bin/env python3
"""Tries CONTRIBUTING.md: its commands and files exist, and what it says of adding things works as it
is written.

how_to_test.py commands SOURCE_DIR        every command and path that the page names exists
how_to_test.py HOW_TO SOURCE_DIR WORK_DIR add_a_dial, add_an_effect or add_a_method: follows it in a copy
                                          of the tree, builds, and runs the shared laws on the new one
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


def copy_of(source, work, *folders):
    """A copy of the tree in which only these folders of tests are left."""
    tree = os.path.join(work, "tree")
    shutil.rmtree(work, ignore_errors=True)
    shutil.copytree(source, tree, ignore=shutil.ignore_patterns("build*", ".git", "out", "node_modules"))
    for folder in os.listdir(os.path.join(tree, "tests")):
        keep = folder in folders + ("support", "data", "peers")
        if not keep and os.path.isdir(os.path.join(tree, "tests", folder)):
            shutil.rmtree(os.path.join(tree, "tests", folder))
    return tree


def try_laws(tree, folder, laws, least):
    """Builds one folder's tests and runs those that try the new one: at least so many."""
    build = os.path.join(tree, "build/release")
    run = lambda *command: subprocess.run(command, cwd=tree, check=True)
    run("cmake", "--preset", "release", "-DSIXDIAL_BENCH=OFF", "-DSIXDIAL_REPORT_CHARTS=OFF",
        "-DSIXDIAL_TESTS=ON")
    run("cmake", "--build", build, "--target", "test_" + folder)
    told = subprocess.run([os.path.join(build, "bin/test_" + folder), "--gtest_filter=" + laws],
                          capture_output=True, text=True)
    print(told.stdout[-2000:])
    passed = re.search(r"\[  PASSED  \] (\d+) tests?", told.stdout)
    if told.returncode != 0 or not passed or int(passed[1]) < least:
        fail(f"the shared laws of tests/{folder} were not passed by the new one: {laws}")
    return told.stdout


def add_a_dial(source, work):
    tree = copy_of(source, work, "acquisition")
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
    try_laws(tree, "acquisition", "*EveryDial*plain*", 4)


def add_an_effect(source, work):
    tree = copy_of(source, work, "simulation", "effects")
    example = os.path.join(source, "tests/howto/add_an_effect")
    # Steps 1 and 2: its file, and its name in the list.
    shutil.copy(os.path.join(example, "joint_third_harmonic.cpp"),
                os.path.join(tree, "simulation/effects"))
    put(tree, "simulation/effects/all_effects.cpp", "joint_second_harmonic,",
        "joint_second_harmonic, joint_third_harmonic,")
    put(tree, "simulation/effects/all_effects.cpp", "    &joint_second_harmonic,\n",
        "    &joint_second_harmonic,\n    &joint_third_harmonic,\n")
    # Step 3: its twin, and the twin's name in the list.
    shutil.copy(os.path.join(example, "mock_joint_third_harmonic.cpp"),
                os.path.join(tree, "mock_devices/hidden/joint_third_harmonic.cpp"))
    put(tree, "mock_devices/hidden/all_causes.cpp", "joint_second_harmonic,",
        "joint_second_harmonic, joint_third_harmonic,")
    put(tree, "mock_devices/hidden/all_causes.cpp", "&stale_reading,",
        "&stale_reading, &joint_third_harmonic,")
    # Step 4: the laws, at both joints; the catalogue's own; the twin's. Both parameters are in
    # the words that the report says of its size.
    told = try_laws(tree, "simulation", "*EveryEffect*joint_third_harmonic*:Effects.*", 12)
    for parameter in "a", "b":
        if not re.search(r"joint_third_harmonic at joint2: .*\b%s [\d.]+\u00b0" % parameter, told):
            fail(f"the words for its size leave out its parameter {parameter}")
    try_laws(tree, "effects", "*EveryTwin*joint_third_harmonic*:Twins.*", 2)


def add_a_method(source, work):
    tree = copy_of(source, work, "calibration")
    # Steps 1 and 2: its file, and its row in the table.
    shutil.copy(os.path.join(source, "tests/howto/add_a_method/lm_cauchy.cpp"),
                os.path.join(tree, "calibration/identifiers"))
    put(tree, "calibration/identifier.cpp", "extern const Identifier lm;",
        "extern const Identifier lm;\nextern const Identifier lm_cauchy;")
    put(tree, "calibration/identifier.cpp", "&lm, &tikhonov", "&lm, &lm_cauchy, &tikhonov")
    # Step 3: the laws; the other tests of the folder are not about identifiers.
    tests = os.path.join(tree, "tests/calibration")
    for name in os.listdir(tests):
        if name.endswith("_test.cpp") and "identifier" not in name:
            os.remove(os.path.join(tests, name))
    try_laws(tree, "calibration", "*EveryIdentifier*lm_cauchy*:Identifiers.*", 4)


HOW_TOS = {"add_a_dial": add_a_dial, "add_an_effect": add_an_effect, "add_a_method": add_a_method}

if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "commands":
        commands(sys.argv[2])
    elif len(sys.argv) == 4 and sys.argv[1] in HOW_TOS:
        work = os.path.abspath(sys.argv[3])
        HOW_TOS[sys.argv[1]](os.path.abspath(sys.argv[2]), work)
        shutil.rmtree(work, ignore_errors=True)
    else:
        fail(__doc__)
