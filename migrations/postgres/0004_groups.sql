-- Jobs, rides, bikes and what was identified belong to groups that see nothing of each other; what was there before
-- belongs to the group `default`. SQLite has to build tables anew for this, so ../sqlite reads differently.

ALTER TABLE job DROP CONSTRAINT job_bike_fkey;

ALTER TABLE bike ADD COLUMN group_name TEXT NOT NULL DEFAULT 'default';
ALTER TABLE bike ALTER COLUMN group_name DROP DEFAULT;
ALTER TABLE bike DROP CONSTRAINT bike_pkey;
ALTER TABLE bike ADD PRIMARY KEY (group_name, name);

ALTER TABLE ride ADD COLUMN group_name TEXT NOT NULL DEFAULT 'default';
ALTER TABLE ride ALTER COLUMN group_name DROP DEFAULT;
ALTER TABLE ride DROP CONSTRAINT ride_sha256_name_key;
ALTER TABLE ride ADD UNIQUE (group_name, sha256, name);

ALTER TABLE job ADD COLUMN group_name TEXT NOT NULL DEFAULT 'default';
ALTER TABLE job ALTER COLUMN group_name DROP DEFAULT;
ALTER TABLE job ADD COLUMN key_id UUID REFERENCES api_key (id);
ALTER TABLE job ADD FOREIGN KEY (group_name, bike) REFERENCES bike (group_name, name);

ALTER TABLE idempotency_key ADD COLUMN group_name TEXT NOT NULL DEFAULT 'default';
ALTER TABLE idempotency_key ALTER COLUMN group_name DROP DEFAULT;
ALTER TABLE idempotency_key DROP CONSTRAINT idempotency_key_pkey;
ALTER TABLE idempotency_key ADD PRIMARY KEY (group_name, name);

ALTER TABLE parameter ADD COLUMN group_name TEXT NOT NULL DEFAULT 'default';
ALTER TABLE parameter ALTER COLUMN group_name DROP DEFAULT;

DROP INDEX job_bike;
DROP INDEX parameter_bike;
DROP INDEX parameter_name;
DROP INDEX parameter_verdict;
DROP INDEX parameter_both;

CREATE INDEX job_group ON job (group_name, id);
CREATE INDEX job_bike ON job (group_name, bike, id);
CREATE INDEX job_key ON job (key_id, state);
CREATE INDEX parameter_group ON parameter (group_name, job_id, method, axle, name);
CREATE INDEX parameter_bike ON parameter (group_name, bike, job_id, method, axle, name);
CREATE INDEX parameter_name ON parameter (group_name, name, job_id, method, axle);
CREATE INDEX parameter_verdict ON parameter (group_name, verdict, job_id, method, axle, name);
CREATE INDEX parameter_both ON parameter (group_name, job_id, method, axle, name) WHERE axle = 'both';
