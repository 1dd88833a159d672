-- Times are epoch milliseconds, ids UUIDv7, documents JSON. The same tables stand in ../postgres.

-- The fleet: the bike file of each bicycle as it was last uploaded.
CREATE TABLE bike (
    name       TEXT PRIMARY KEY,
    document   TEXT NOT NULL,
    created_at INTEGER NOT NULL,
    updated_at INTEGER NOT NULL
) STRICT;

-- Uploaded files; the bytes lie in the file store under their SHA-256.
CREATE TABLE ride (
    id          BLOB PRIMARY KEY,
    sha256      TEXT NOT NULL,
    name        TEXT NOT NULL,
    bytes       INTEGER NOT NULL,
    uploaded_at INTEGER NOT NULL,
    UNIQUE (sha256, name)
) STRICT;

-- One identification. River's rows carry the work, this one what users see.
CREATE TABLE job (
    id            BLOB PRIMARY KEY,
    ride_id       BLOB NOT NULL REFERENCES ride (id),
    bike          TEXT NOT NULL REFERENCES bike (name),
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
    CHECK ((finished_at IS NULL) = (state IN ('queued', 'running')))
) STRICT;

CREATE INDEX job_state ON job (state, id);
CREATE INDEX job_bike ON job (bike, id);
CREATE INDEX job_ride ON job (ride_id, id);
CREATE INDEX job_fingerprint ON job (fingerprint);

-- One swarm from one seed; cost and result are null until it is done.
CREATE TABLE trial (
    job_id      BLOB NOT NULL REFERENCES job (id) ON DELETE CASCADE,
    trial_index INTEGER NOT NULL,
    seed        INTEGER NOT NULL,
    river_id    INTEGER NOT NULL,
    cost        REAL,
    result      TEXT,
    finished_at INTEGER,
    PRIMARY KEY (job_id, trial_index)
) STRICT;

CREATE INDEX trial_river ON trial (river_id);

-- What a stage hands to the next one, and at last the report.
CREATE TABLE result (
    job_id   BLOB NOT NULL REFERENCES job (id) ON DELETE CASCADE,
    name     TEXT NOT NULL CHECK (name IN ('observed', 'conclusion', 'report')),
    document TEXT NOT NULL,
    PRIMARY KEY (job_id, name)
) STRICT;

-- Every identified parameter of every finished job.
CREATE TABLE parameter (
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
    PRIMARY KEY (job_id, method, axle, name)
) STRICT;

CREATE INDEX parameter_bike ON parameter (bike, job_id, method, axle, name);
CREATE INDEX parameter_name ON parameter (name, job_id, method, axle);

CREATE TABLE idempotency_key (
    name        TEXT PRIMARY KEY,
    fingerprint TEXT NOT NULL,
    job_id      BLOB NOT NULL REFERENCES job (id) ON DELETE CASCADE,
    created_at  INTEGER NOT NULL
) STRICT;

-- Processes that work on jobs; beat_at is the database's own clock.
CREATE TABLE worker (
    id         TEXT PRIMARY KEY,
    version    TEXT NOT NULL,
    slots      INTEGER NOT NULL,
    started_at INTEGER NOT NULL,
    beat_at    INTEGER NOT NULL
) STRICT;
