-- Long work and what came of it. Results are never changed; a job's state is.
CREATE TABLE jobs (
  id INTEGER PRIMARY KEY,
  kind TEXT NOT NULL CHECK (kind <> ''),
  session_id INTEGER REFERENCES sessions (id),
  state TEXT NOT NULL CHECK (state IN ('queued', 'running', 'done', 'failed', 'cancelled')),
  request TEXT NOT NULL,
  progress TEXT NOT NULL DEFAULT '{}',
  error TEXT NOT NULL DEFAULT '',
  operator TEXT NOT NULL DEFAULT '',
  operator_uid INTEGER,
  operator_pid INTEGER,
  created_utc TEXT NOT NULL,
  started_utc TEXT,
  finished_utc TEXT
) STRICT;

CREATE TABLE results (
  id INTEGER PRIMARY KEY,
  kind TEXT NOT NULL CHECK (kind <> ''),
  session_id INTEGER NOT NULL REFERENCES sessions (id),
  job_id INTEGER REFERENCES jobs (id),
  rig_sha256 TEXT NOT NULL,
  data_sha256 TEXT NOT NULL,
  seed TEXT NOT NULL,
  program_version TEXT NOT NULL,
  settings TEXT NOT NULL,
  result TEXT NOT NULL,
  created_utc TEXT NOT NULL
) STRICT;
CREATE INDEX results_by_session ON results (session_id, kind);

-- Who did what.
CREATE TABLE actions (
  id INTEGER PRIMARY KEY,
  time_utc TEXT NOT NULL,
  operator TEXT NOT NULL DEFAULT '',
  operator_uid INTEGER,
  operator_pid INTEGER,
  action TEXT NOT NULL,
  session_id INTEGER REFERENCES sessions (id),
  detail TEXT NOT NULL DEFAULT ''
) STRICT;

CREATE TRIGGER results_stay_as_they_are BEFORE UPDATE ON results
BEGIN
  SELECT RAISE(ABORT, 'results are never changed');
END;
CREATE TRIGGER results_are_kept BEFORE DELETE ON results
BEGIN
  SELECT RAISE(ABORT, 'results are never deleted');
END;
CREATE TRIGGER jobs_are_kept BEFORE DELETE ON jobs
BEGIN
  SELECT RAISE(ABORT, 'jobs are never deleted');
END;
CREATE TRIGGER actions_stay_as_they_are BEFORE UPDATE ON actions
BEGIN
  SELECT RAISE(ABORT, 'actions are never changed');
END;
CREATE TRIGGER actions_are_kept BEFORE DELETE ON actions
BEGIN
  SELECT RAISE(ABORT, 'actions are never deleted');
END;
