#!/usr/bin/env python3
"""schema_1.db and schema_2.db from schema_3.db: the tables that the program of that schema made, with the same
rows. Usage: earlier.py REPOSITORY SCHEMA_3_DB N OUTPUT"""
import glob, os, sqlite3, sys

repository, source, newest, output = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]
if os.path.exists(output):
    os.remove(output)
base = sqlite3.connect(output)
base.execute("PRAGMA journal_mode = WAL")
for path in sorted(glob.glob(repository + "/db/migrations/*.sql"))[:newest]:
    base.executescript(open(path).read())
base.execute(f"PRAGMA application_id = {0x5358444C}")
base.execute(f"PRAGMA user_version = {newest}")
base.execute("ATTACH ? AS old", (source,))
tables = ["rigs", "sessions", "samples", "readings", "withdrawals", "rejected_rows", "plans", "plan_points"]
if newest >= 2:
    tables += ["jobs", "results", "actions"]
for table in tables:
    base.execute(f"INSERT INTO main.{table} SELECT * FROM old.{table}")
base.commit()
base.execute("DETACH old")
base.execute("PRAGMA wal_checkpoint(TRUNCATE)")
base.execute("VACUUM")
base.close()
