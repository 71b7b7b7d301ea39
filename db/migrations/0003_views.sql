-- For pandas.read_sql and people: units in the column names, names instead of ids.
CREATE VIEW v_sessions AS
SELECT s.id AS session_id, s.name AS session, s.origin, s.note, s.created_utc, s.operator,
       r.sha256 AS rig_sha256,
       (SELECT count(*) FROM live_samples AS l WHERE l.session_id = s.id) AS samples,
       (SELECT count(*) FROM rejected_rows AS j WHERE j.session_id = s.id) AS rejected_rows,
       (SELECT count(*) FROM results AS e WHERE e.session_id = s.id) AS results
FROM sessions AS s JOIN rigs AS r ON r.id = s.rig_id;

-- Every raw sample; is_live = 0: retaken or undone.
CREATE VIEW v_samples AS
SELECT s.id AS sample_id, e.name AS session, s.set_name, s.point, s.repeat, s.time_utc,
       s.theta1_rad, s.theta2_rad, s.target_x_mm, s.target_y_mm, s.approach1, s.approach2,
       s.temperature_c, s.x_mm, s.y_mm, s.supersedes,
       EXISTS (SELECT 1 FROM live_samples AS l WHERE l.id = s.id) AS is_live
FROM samples AS s JOIN sessions AS e ON e.id = s.session_id;

CREATE VIEW v_readings AS
SELECT v.session, v.set_name, v.point, v.repeat, v.is_live, r.sample_id, r.dial,
       r.value_mm AS displacement_mm, r.quality, r.reason, r.time_utc, v.theta1_rad,
       v.theta2_rad, v.temperature_c
FROM readings AS r JOIN v_samples AS v ON v.sample_id = r.sample_id;

CREATE VIEW v_results AS
SELECT t.id AS result_id, s.name AS session, t.kind, t.created_utc, t.seed, t.program_version,
       t.rig_sha256, t.data_sha256, t.settings, t.result
FROM results AS t JOIN sessions AS s ON s.id = t.session_id;
