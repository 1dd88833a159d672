-- Jobs, rides, bikes and what was identified belong to groups that see nothing of each other; what was there before
-- belongs to the group `default`. SQLite changes a key only by building the table anew, and the migrator sees to it
-- that dropping the old one takes nothing along; ../postgres alters its tables in place.

CREATE TABLE new_bike (
    name       TEXT NOT NULL,
    document   TEXT NOT NULL,
    created_at INTEGER NOT NULL,
    updated_at INTEGER NOT NULL,
    group_name TEXT NOT NULL,
    PRIMARY KEY (group_name, name)
) STRICT;
INSERT INTO new_bike SELECT name, document, created_at, updated_at, 'default' FROM bike;
DROP TABLE bike;
ALTER TABLE new_bike RENAME TO bike;

CREATE TABLE new_ride (
    id          BLOB PRIMARY KEY,
    sha256      TEXT NOT NULL,
    name        TEXT NOT NULL,
    bytes       INTEGER NOT NULL,
    uploaded_at INTEGER NOT NULL,
    group_name  TEXT NOT NULL,
    UNIQUE (group_name, sha256, name)
) STRICT;
INSERT INTO new_ride SELECT id, sha256, name, bytes, uploaded_at, 'default' FROM ride;
DROP TABLE ride;
ALTER TABLE new_ride RENAME TO ride;

CREATE TABLE new_job (
    id            BLOB PRIMARY KEY,
    ride_id       BLOB NOT NULL REFERENCES ride (id),
    bike          TEXT NOT NULL,
    fingerprint   TEXT NOT NULL,
    request       TEXT NOT NULL,
    summary       TEXT NOT NULL,
    state         TEXT NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    stage         TEXT NOT NULL CHECK (stage IN ('observe', 'trial', 'conclude', 'diagnose')),
    revision      INTEGER NOT NULL,
    trials_total  INTEGER NOT NULL,
    trials_done   INTEGER NOT NULL CHECK (trials_done BETWEEN 0 AND trials_total),
    takeovers     INTEGER NOT NULL,
    river_id      INTEGER,
    least_squares TEXT,
    verdict       TEXT,
    failure       TEXT,
    created_at    INTEGER NOT NULL,
    started_at    INTEGER,
    observed_at   INTEGER,
    finished_at   INTEGER,
    group_name    TEXT NOT NULL,
    key_id        BLOB REFERENCES api_key (id),
    FOREIGN KEY (group_name, bike) REFERENCES bike (group_name, name),
    CHECK ((finished_at IS NULL) = (state IN ('queued', 'running')))
) STRICT;
INSERT INTO new_job SELECT
    id, ride_id, bike, fingerprint, request, summary, state, stage, revision, trials_total, trials_done, takeovers,
    river_id, least_squares, verdict, failure, created_at, started_at, observed_at, finished_at, 'default', NULL
FROM job;
DROP TABLE job;
ALTER TABLE new_job RENAME TO job;

CREATE TABLE new_idempotency_key (
    name        TEXT NOT NULL,
    fingerprint TEXT NOT NULL,
    job_id      BLOB NOT NULL REFERENCES job (id) ON DELETE CASCADE,
    created_at  INTEGER NOT NULL,
    group_name  TEXT NOT NULL,
    PRIMARY KEY (group_name, name)
) STRICT;
INSERT INTO new_idempotency_key SELECT name, fingerprint, job_id, created_at, 'default' FROM idempotency_key;
DROP TABLE idempotency_key;
ALTER TABLE new_idempotency_key RENAME TO idempotency_key;

CREATE TABLE new_parameter (
    job_id        BLOB NOT NULL REFERENCES job (id) ON DELETE CASCADE,
    method        TEXT NOT NULL,
    axle          TEXT NOT NULL CHECK (axle IN ('front', 'rear', 'both')),
    name          TEXT NOT NULL,
    bike          TEXT NOT NULL,
    value         REAL NOT NULL,
    std_error     REAL,
    unit          TEXT NOT NULL,
    verdict       TEXT,
    version       TEXT NOT NULL,
    identified_at INTEGER NOT NULL,
    group_name    TEXT NOT NULL,
    PRIMARY KEY (job_id, method, axle, name)
) STRICT;
INSERT INTO new_parameter SELECT
    job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at, 'default'
FROM parameter;
DROP TABLE parameter;
ALTER TABLE new_parameter RENAME TO parameter;

CREATE INDEX job_state ON job (state, id);
CREATE INDEX job_ride ON job (ride_id, id);
CREATE INDEX job_fingerprint ON job (fingerprint);
CREATE INDEX job_group ON job (group_name, id);
CREATE INDEX job_bike ON job (group_name, bike, id);
CREATE INDEX job_key ON job (key_id, state);
CREATE INDEX parameter_group ON parameter (group_name, job_id, method, axle, name);
CREATE INDEX parameter_bike ON parameter (group_name, bike, job_id, method, axle, name);
CREATE INDEX parameter_name ON parameter (group_name, name, job_id, method, axle);
CREATE INDEX parameter_verdict ON parameter (group_name, verdict, job_id, method, axle, name);
CREATE INDEX parameter_both ON parameter (group_name, job_id, method, axle, name) WHERE axle = 'both';
