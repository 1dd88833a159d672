-- Jobs whose report may hold a null where a number must stand, and those that failed of one: server/jobs/repair.rs looks
-- at each once and begins it anew where need be. The swarm's scatter over its trials was kept as a standard error.
CREATE TABLE repair (
    job_id BLOB PRIMARY KEY REFERENCES job (id) ON DELETE CASCADE
) STRICT;
INSERT INTO repair
SELECT job_id FROM result WHERE name = 'report' AND CAST(document AS TEXT) LIKE '%null%'
UNION
SELECT id FROM job WHERE state = 'failed' AND CAST(failure AS TEXT) LIKE '%invalid type: null, expected f64%';
UPDATE parameter SET std_error = NULL WHERE method = 'swarm';
