-- Sessions, rigs, plans and raw samples. Raw rows are never changed: a retake or an undo is a new row.
CREATE TABLE rigs (
  id INTEGER PRIMARY KEY,
  sha256 TEXT NOT NULL UNIQUE CHECK (length(sha256) = 64),
  text TEXT NOT NULL
) STRICT;

CREATE TABLE sessions (
  id INTEGER PRIMARY KEY,
  name TEXT NOT NULL UNIQUE CHECK (name <> ''),
  rig_id INTEGER NOT NULL REFERENCES rigs (id),
  origin TEXT NOT NULL CHECK (origin IN ('measured', 'imported')),
  note TEXT NOT NULL DEFAULT '',
  created_utc TEXT NOT NULL,
  operator TEXT NOT NULL DEFAULT '',
  operator_uid INTEGER,
  operator_pid INTEGER,
  program_version TEXT NOT NULL,
  csv_header TEXT NOT NULL DEFAULT '',
  line_end TEXT NOT NULL,
  csv_end TEXT NOT NULL
) STRICT;

CREATE TABLE samples (
  id INTEGER PRIMARY KEY,
  session_id INTEGER NOT NULL REFERENCES sessions (id),
  set_name TEXT NOT NULL CHECK (set_name <> ''),
  point INTEGER NOT NULL CHECK (point >= 0),
  repeat INTEGER NOT NULL CHECK (repeat >= 0),
  time_utc TEXT,
  theta1_rad REAL NOT NULL,
  theta2_rad REAL NOT NULL,
  target_x_mm REAL,
  target_y_mm REAL,
  approach1 INTEGER CHECK (approach1 IN (-1, 0, 1)),
  approach2 INTEGER CHECK (approach2 IN (-1, 0, 1)),
  temperature_c REAL,
  x_mm REAL,
  y_mm REAL,
  line INTEGER NOT NULL DEFAULT 0,
  source_row TEXT NOT NULL DEFAULT '',
  supersedes INTEGER REFERENCES samples (id),
  stored_utc TEXT NOT NULL
) STRICT;
CREATE INDEX samples_by_key ON samples (session_id, set_name, point, repeat);
CREATE INDEX samples_by_superseded ON samples (supersedes) WHERE supersedes IS NOT NULL;

CREATE TABLE readings (
  sample_id INTEGER NOT NULL REFERENCES samples (id),
  dial_index INTEGER NOT NULL CHECK (dial_index >= 0),
  dial TEXT NOT NULL,
  value_mm REAL,
  quality TEXT NOT NULL CHECK (quality IN ('good', 'uncertain', 'bad')),
  reason TEXT NOT NULL DEFAULT '',
  time_utc TEXT,
  PRIMARY KEY (sample_id, dial_index)
) STRICT, WITHOUT ROWID;

-- An undone sample: it stays, and no longer counts.
CREATE TABLE withdrawals (
  sample_id INTEGER PRIMARY KEY REFERENCES samples (id),
  reason TEXT NOT NULL DEFAULT '',
  operator TEXT NOT NULL DEFAULT '',
  stored_utc TEXT NOT NULL
) STRICT;

CREATE TABLE rejected_rows (
  session_id INTEGER NOT NULL REFERENCES sessions (id),
  line INTEGER NOT NULL,
  text TEXT NOT NULL,
  reason TEXT NOT NULL,
  PRIMARY KEY (session_id, line)
) STRICT, WITHOUT ROWID;

-- The newest plan of a session is the one that counts.
CREATE TABLE plans (
  id INTEGER PRIMARY KEY,
  session_id INTEGER NOT NULL REFERENCES sessions (id),
  created_utc TEXT NOT NULL
) STRICT;
CREATE INDEX plans_by_session ON plans (session_id);

CREATE TABLE plan_points (
  plan_id INTEGER NOT NULL REFERENCES plans (id),
  position INTEGER NOT NULL,
  set_name TEXT NOT NULL,
  point INTEGER NOT NULL,
  repeat INTEGER NOT NULL,
  target_x_mm REAL NOT NULL,
  target_y_mm REAL NOT NULL,
  theta1_rad REAL NOT NULL,
  theta2_rad REAL NOT NULL,
  approach1 INTEGER NOT NULL CHECK (approach1 IN (-1, 0, 1)),
  approach2 INTEGER NOT NULL CHECK (approach2 IN (-1, 0, 1)),
  PRIMARY KEY (plan_id, position),
  UNIQUE (plan_id, set_name, point, repeat)
) STRICT, WITHOUT ROWID;

-- A sample counts unless it was withdrawn or a counting sample took its place.
CREATE VIEW live_samples AS
SELECT s.* FROM samples AS s
WHERE NOT EXISTS (SELECT 1 FROM withdrawals AS w WHERE w.sample_id = s.id)
  AND NOT EXISTS (
    SELECT 1 FROM samples AS newer
    WHERE newer.supersedes = s.id
      AND NOT EXISTS (SELECT 1 FROM withdrawals AS w WHERE w.sample_id = newer.id));

CREATE TRIGGER one_live_sample_a_key BEFORE INSERT ON samples
WHEN EXISTS (
  SELECT 1 FROM live_samples AS s
  WHERE s.session_id = NEW.session_id AND s.set_name = NEW.set_name AND s.point = NEW.point
    AND s.repeat = NEW.repeat AND s.id IS NOT NEW.supersedes)
BEGIN
  SELECT RAISE(ABORT, 'this set, point and repeat is measured already');
END;

CREATE TRIGGER samples_stay_as_they_are BEFORE UPDATE ON samples
BEGIN
  SELECT RAISE(ABORT, 'raw samples are never changed');
END;
CREATE TRIGGER samples_are_kept BEFORE DELETE ON samples
BEGIN
  SELECT RAISE(ABORT, 'raw samples are never deleted');
END;
CREATE TRIGGER readings_stay_as_they_are BEFORE UPDATE ON readings
BEGIN
  SELECT RAISE(ABORT, 'raw readings are never changed');
END;
CREATE TRIGGER readings_are_kept BEFORE DELETE ON readings
BEGIN
  SELECT RAISE(ABORT, 'raw readings are never deleted');
END;
CREATE TRIGGER withdrawals_stay_as_they_are BEFORE UPDATE ON withdrawals
BEGIN
  SELECT RAISE(ABORT, 'withdrawals are never changed');
END;
CREATE TRIGGER withdrawals_are_kept BEFORE DELETE ON withdrawals
BEGIN
  SELECT RAISE(ABORT, 'withdrawals are never deleted');
END;
CREATE TRIGGER rejected_rows_stay_as_they_are BEFORE UPDATE ON rejected_rows
BEGIN
  SELECT RAISE(ABORT, 'rejected rows are never changed');
END;
CREATE TRIGGER rejected_rows_are_kept BEFORE DELETE ON rejected_rows
BEGIN
  SELECT RAISE(ABORT, 'rejected rows are never deleted');
END;
CREATE TRIGGER rigs_stay_as_they_are BEFORE UPDATE ON rigs
BEGIN
  SELECT RAISE(ABORT, 'rigs are never changed: another rig file is another rig');
END;
CREATE TRIGGER rigs_are_kept BEFORE DELETE ON rigs
BEGIN
  SELECT RAISE(ABORT, 'rigs are never deleted');
END;
CREATE TRIGGER sessions_keep_their_rig BEFORE UPDATE OF id, rig_id, csv_header, line_end, csv_end
ON sessions
BEGIN
  SELECT RAISE(ABORT, 'a session keeps its rig and its source');
END;
CREATE TRIGGER sessions_are_kept BEFORE DELETE ON sessions
BEGIN
  SELECT RAISE(ABORT, 'sessions are never deleted');
END;
