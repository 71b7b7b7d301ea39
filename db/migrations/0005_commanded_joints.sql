-- The value that each joint was told, beside the one that was read back: NULL where a session
-- does not say.
DROP VIEW v_joints;
ALTER TABLE sample_joints ADD COLUMN commanded REAL;

-- One row a joint of each raw sample.
CREATE VIEW v_joints AS
SELECT v.session, v.set_name, v.point, v.repeat, v.is_live, j.sample_id, j.joint, j.unit,
       j.value, j.approach, j.commanded
FROM sample_joints AS j JOIN v_samples AS v ON v.sample_id = j.sample_id;
