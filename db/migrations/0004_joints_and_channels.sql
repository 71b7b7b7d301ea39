-- A sample has a value for each joint of its robot and each channel of its instrument, however
-- many there are: rows of child tables instead of columns. Every row of before is kept, and the
-- views of 0003 keep their columns and values.
DROP VIEW v_readings;
DROP VIEW v_samples;

CREATE TABLE sample_joints (
  sample_id INTEGER NOT NULL REFERENCES samples (id),
  joint_index INTEGER NOT NULL CHECK (joint_index >= 0),
  joint TEXT NOT NULL,
  unit TEXT NOT NULL,
  value REAL NOT NULL,
  approach INTEGER CHECK (approach IN (-1, 0, 1)),
  PRIMARY KEY (sample_id, joint_index)
) STRICT, WITHOUT ROWID;

INSERT INTO sample_joints (sample_id, joint_index, joint, unit, value, approach)
SELECT id, 0, 'theta1', 'rad', theta1_rad, approach1 FROM samples
UNION ALL
SELECT id, 1, 'theta2', 'rad', theta2_rad, approach2 FROM samples
ORDER BY 1, 2;

-- Channels are named like the columns of session.csv without the unit: dial_A, x, y.
CREATE TABLE sample_channels (
  sample_id INTEGER NOT NULL REFERENCES samples (id),
  channel_index INTEGER NOT NULL CHECK (channel_index >= 0),
  channel TEXT NOT NULL,
  unit TEXT NOT NULL,
  value REAL,
  quality TEXT NOT NULL CHECK (quality IN ('good', 'uncertain', 'bad')),
  reason TEXT NOT NULL DEFAULT '',
  time_utc TEXT,
  PRIMARY KEY (sample_id, channel_index)
) STRICT, WITHOUT ROWID;

INSERT INTO sample_channels
  (sample_id, channel_index, channel, unit, value, quality, reason, time_utc)
SELECT sample_id, dial_index, 'dial_' || dial, 'mm', value_mm, quality, reason, time_utc
FROM readings
UNION ALL
SELECT s.id, (SELECT count(*) FROM readings AS r WHERE r.sample_id = s.id), 'x', 'mm', s.x_mm,
       'good', '', NULL
FROM samples AS s WHERE s.x_mm IS NOT NULL
UNION ALL
SELECT s.id, (SELECT count(*) FROM readings AS r WHERE r.sample_id = s.id) + 1, 'y', 'mm',
       s.y_mm, 'good', '', NULL
FROM samples AS s WHERE s.y_mm IS NOT NULL
ORDER BY 1, 2;

CREATE TABLE plan_joints (
  plan_id INTEGER NOT NULL,
  position INTEGER NOT NULL,
  joint_index INTEGER NOT NULL CHECK (joint_index >= 0),
  joint TEXT NOT NULL,
  unit TEXT NOT NULL,
  value REAL NOT NULL,
  approach INTEGER NOT NULL CHECK (approach IN (-1, 0, 1)),
  PRIMARY KEY (plan_id, position, joint_index),
  FOREIGN KEY (plan_id, position) REFERENCES plan_points (plan_id, position)
) STRICT, WITHOUT ROWID;

INSERT INTO plan_joints (plan_id, position, joint_index, joint, unit, value, approach)
SELECT plan_id, position, 0, 'theta1', 'rad', theta1_rad, approach1 FROM plan_points
UNION ALL
SELECT plan_id, position, 1, 'theta2', 'rad', theta2_rad, approach2 FROM plan_points
ORDER BY 1, 2, 3;

DROP TABLE readings;
ALTER TABLE samples DROP COLUMN theta1_rad;
ALTER TABLE samples DROP COLUMN theta2_rad;
ALTER TABLE samples DROP COLUMN approach1;
ALTER TABLE samples DROP COLUMN approach2;
ALTER TABLE samples DROP COLUMN x_mm;
ALTER TABLE samples DROP COLUMN y_mm;
ALTER TABLE samples ADD COLUMN target_z_mm REAL;
ALTER TABLE plan_points DROP COLUMN theta1_rad;
ALTER TABLE plan_points DROP COLUMN theta2_rad;
ALTER TABLE plan_points DROP COLUMN approach1;
ALTER TABLE plan_points DROP COLUMN approach2;
ALTER TABLE plan_points ADD COLUMN target_z_mm REAL;

CREATE TRIGGER sample_joints_stay_as_they_are BEFORE UPDATE ON sample_joints
BEGIN
  SELECT RAISE(ABORT, 'raw joint values are never changed');
END;
CREATE TRIGGER sample_joints_are_kept BEFORE DELETE ON sample_joints
BEGIN
  SELECT RAISE(ABORT, 'raw joint values are never deleted');
END;
CREATE TRIGGER sample_channels_stay_as_they_are BEFORE UPDATE ON sample_channels
BEGIN
  SELECT RAISE(ABORT, 'raw readings are never changed');
END;
CREATE TRIGGER sample_channels_are_kept BEFORE DELETE ON sample_channels
BEGIN
  SELECT RAISE(ABORT, 'raw readings are never deleted');
END;

-- Every raw sample; is_live = 0: retaken or undone. The joints of another robot than the
-- five-bar are in v_joints, more channels in v_channels.
CREATE VIEW v_samples AS
SELECT s.id AS sample_id, e.name AS session, s.set_name, s.point, s.repeat, s.time_utc,
       q1.value AS theta1_rad, q2.value AS theta2_rad, s.target_x_mm, s.target_y_mm,
       q1.approach AS approach1, q2.approach AS approach2, s.temperature_c,
       (SELECT c.value FROM sample_channels AS c WHERE c.sample_id = s.id AND c.channel = 'x')
         AS x_mm,
       (SELECT c.value FROM sample_channels AS c WHERE c.sample_id = s.id AND c.channel = 'y')
         AS y_mm,
       s.supersedes,
       EXISTS (SELECT 1 FROM live_samples AS l WHERE l.id = s.id) AS is_live
FROM samples AS s JOIN sessions AS e ON e.id = s.session_id
LEFT JOIN sample_joints AS q1
  ON q1.sample_id = s.id AND q1.joint_index = 0 AND q1.joint = 'theta1'
LEFT JOIN sample_joints AS q2
  ON q2.sample_id = s.id AND q2.joint_index = 1 AND q2.joint = 'theta2';

CREATE VIEW v_readings AS
SELECT v.session, v.set_name, v.point, v.repeat, v.is_live, c.sample_id,
       substr(c.channel, 6) AS dial, c.value AS displacement_mm, c.quality, c.reason,
       c.time_utc, v.theta1_rad, v.theta2_rad, v.temperature_c
FROM sample_channels AS c JOIN v_samples AS v ON v.sample_id = c.sample_id
WHERE substr(c.channel, 1, 5) = 'dial_';

-- One row a joint of each raw sample.
CREATE VIEW v_joints AS
SELECT v.session, v.set_name, v.point, v.repeat, v.is_live, j.sample_id, j.joint, j.unit,
       j.value, j.approach
FROM sample_joints AS j JOIN v_samples AS v ON v.sample_id = j.sample_id;

-- One row a channel of each raw sample: dials, and coordinates where an instrument gave them.
CREATE VIEW v_channels AS
SELECT v.session, v.set_name, v.point, v.repeat, v.is_live, c.sample_id, c.channel, c.unit,
       c.value, c.quality, c.reason, c.time_utc
FROM sample_channels AS c JOIN v_samples AS v ON v.sample_id = c.sample_id;
