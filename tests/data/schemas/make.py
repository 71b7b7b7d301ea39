#!/usr/bin/env python3
"""Writes schema_<n>.db: a database as the program of schema n left it. Once for each schema, when
it is new; the files are kept for ever. Usage: make.py REPOSITORY N OUTPUT"""
import glob, hashlib, os, sqlite3, sys

repository, newest, output = sys.argv[1], int(sys.argv[2]), sys.argv[3]
if os.path.exists(output):
    os.remove(output)
base = sqlite3.connect(output)
base.executescript("PRAGMA page_size = 1024; PRAGMA journal_mode = WAL;")
for path in sorted(glob.glob(repository + "/db/migrations/*.sql"))[:newest]:
    base.executescript(open(path).read())
base.execute(f"PRAGMA application_id = {0x5358444C}")
base.execute(f"PRAGMA user_version = {newest}")
rig = open(repository + "/tests/data/sessions/00/rig.toml").read()

base.execute("INSERT INTO rigs VALUES (1, ?, ?)", (hashlib.sha256(rig.encode()).hexdigest(), rig))
when = "2026-01-0%dT08:00:00.000Z"
base.execute(
    "INSERT INTO sessions (id, name, rig_id, origin, note, created_utc, operator, program_version,"
    " line_end, csv_end) VALUES (1, 'old', 1, 'measured', 'kept', ?, 'ann', '0', ?, ?)",
    (when % 1, "\n", "\n"))
base.execute("INSERT INTO plans VALUES (1, 1, ?)", (when % 1,))
JOINTS = (("theta1", 1.5), ("theta2", 3.0))
for point in range(4):
    if newest < 4:
        base.execute("INSERT INTO plan_points VALUES (1, ?, 'G1', ?, 0, 28, 48, 1.5, 3.0, 0, 0)", (point, point))
        continue
    base.execute(
        "INSERT INTO plan_points (plan_id, position, set_name, point, repeat, target_x_mm, target_y_mm)"
        " VALUES (1, ?, 'G1', ?, 0, 28, 48)", (point, point))
    for j, (joint, value) in enumerate(JOINTS):
        base.execute("INSERT INTO plan_joints VALUES (1, ?, ?, ?, 'rad', ?, 0)", (point, j, joint, value))
def sample_of_schema_4(number, point, supersedes):
    base.execute(
        "INSERT INTO samples (id, session_id, set_name, point, repeat, time_utc, temperature_c,"
        " supersedes, stored_utc) VALUES (?, 1, 'G1', ?, 0, ?, 20.5, ?, ?)",
        (number, point, when % 2, supersedes, when % 2))
    for j, (joint, value) in enumerate((("theta1", 1.5 + point / 1000), ("theta2", 3.0))):
        base.execute(
            "INSERT INTO sample_joints (sample_id, joint_index, joint, unit, value) VALUES (?, ?, ?, 'rad', ?)",
            (number, j, joint, value))
    for index, dial in enumerate("ABCDEF"):
        bad = number == 2 and index == 5
        base.execute(
            "INSERT INTO sample_channels VALUES (?, ?, ?, 'mm', ?, ?, ?, ?)",
            (number, index, "dial_" + dial, None if bad else number + index / 1000,
             "bad" if bad else "good", "timeout" if bad else "", when % 2))
def sample(number, point, supersedes=None):
    if newest >= 4:
        sample_of_schema_4(number, point, supersedes)
        return
    base.execute(
        "INSERT INTO samples (id, session_id, set_name, point, repeat, time_utc, theta1_rad,"
        " theta2_rad, temperature_c, supersedes, stored_utc) VALUES (?, 1, 'G1', ?, 0, ?, ?, 3.0,"
        " 20.5, ?, ?)", (number, point, when % 2, 1.5 + point / 1000, supersedes, when % 2))
    for index, dial in enumerate("ABCDEF"):
        bad = number == 2 and index == 5
        base.execute(
            "INSERT INTO readings VALUES (?, ?, ?, ?, ?, ?, ?)",
            (number, index, dial, None if bad else number + index / 1000,
             "bad" if bad else "good", "timeout" if bad else "", when % 2))
sample(1, 0); sample(2, 1); sample(3, 2); sample(4, 0, supersedes=1)
base.execute("INSERT INTO withdrawals VALUES (3, 'slipped', 'ann', ?)", (when % 3,))
if newest >= 2:
    base.execute(
        "INSERT INTO jobs (id, kind, session_id, state, request, created_utc) VALUES"
        " (1, 'calibrate', 1, 'running', '{}', ?)", (when % 3,))
    base.execute(
        "INSERT INTO results VALUES (1, 'calibration', 1, NULL, 'r', 'd', '7', '0', '{}',"
        " '{\"rmse_mm\":0.003}', ?)", (when % 3,))
base.commit()
base.execute("PRAGMA wal_checkpoint(TRUNCATE)")
base.close()
