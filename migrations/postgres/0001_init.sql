-- Times are epoch milliseconds, ids UUIDv7, documents JSON. The same tables stand in ../sqlite.

-- The fleet: the bike file of each bicycle as it was last uploaded.
CREATE TABLE bike (
    name       TEXT PRIMARY KEY,
    document   JSON NOT NULL,
    created_at BIGINT NOT NULL,
    updated_at BIGINT NOT NULL
);

-- Uploaded files; the bytes lie in the file store under their SHA-256.
CREATE TABLE ride (
    id          UUID PRIMARY KEY,
    sha256      TEXT NOT NULL,
    name        TEXT NOT NULL,
    bytes       BIGINT NOT NULL,
    uploaded_at BIGINT NOT NULL,
    UNIQUE (sha256, name)
);

-- One identification. River's rows carry the work, this one what users see.
CREATE TABLE job (
    id            UUID PRIMARY KEY,
    ride_id       UUID NOT NULL REFERENCES ride (id),
    bike          TEXT NOT NULL REFERENCES bike (name),
    fingerprint   TEXT NOT NULL,
    request       JSON NOT NULL,
    summary       JSON NOT NULL,
    state         TEXT NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    stage         TEXT NOT NULL CHECK (stage IN ('observe', 'trial', 'conclude', 'diagnose')),
    revision      BIGINT NOT NULL,
    trials_total  BIGINT NOT NULL,
    trials_done   BIGINT NOT NULL CHECK (trials_done BETWEEN 0 AND trials_total),
    takeovers     BIGINT NOT NULL,
    river_id      BIGINT,
    least_squares JSON,
    verdict       TEXT,
    failure       JSON,
    created_at    BIGINT NOT NULL,
    started_at    BIGINT,
    observed_at   BIGINT,
    finished_at   BIGINT,
    CHECK ((finished_at IS NULL) = (state IN ('queued', 'running')))
);

CREATE INDEX job_state ON job (state, id);
CREATE INDEX job_bike ON job (bike, id);
CREATE INDEX job_ride ON job (ride_id, id);
CREATE INDEX job_fingerprint ON job (fingerprint);

-- One swarm from one seed; cost and result are null until it is done.
CREATE TABLE trial (
    job_id      UUID NOT NULL REFERENCES job (id) ON DELETE CASCADE,
    trial_index BIGINT NOT NULL,
    seed        BIGINT NOT NULL,
    river_id    BIGINT NOT NULL,
    cost        DOUBLE PRECISION,
    result      JSON,
    finished_at BIGINT,
    PRIMARY KEY (job_id, trial_index)
);

CREATE INDEX trial_river ON trial (river_id);

-- What a stage hands to the next one, and at last the report.
CREATE TABLE result (
    job_id   UUID NOT NULL REFERENCES job (id) ON DELETE CASCADE,
    name     TEXT NOT NULL CHECK (name IN ('observed', 'conclusion', 'report')),
    document JSON NOT NULL,
    PRIMARY KEY (job_id, name)
);

-- Every identified parameter of every finished job.
CREATE TABLE parameter (
    job_id        UUID NOT NULL REFERENCES job (id) ON DELETE CASCADE,
    method        TEXT NOT NULL,
    axle          TEXT NOT NULL CHECK (axle IN ('front', 'rear', 'both')),
    name          TEXT NOT NULL,
    bike          TEXT NOT NULL,
    value         DOUBLE PRECISION NOT NULL,
    std_error     DOUBLE PRECISION,
    unit          TEXT NOT NULL,
    verdict       TEXT,
    version       TEXT NOT NULL,
    identified_at BIGINT NOT NULL,
    PRIMARY KEY (job_id, method, axle, name)
);

CREATE INDEX parameter_bike ON parameter (bike, job_id, method, axle, name);
CREATE INDEX parameter_name ON parameter (name, job_id, method, axle);

CREATE TABLE idempotency_key (
    name        TEXT PRIMARY KEY,
    fingerprint TEXT NOT NULL,
    job_id      UUID NOT NULL REFERENCES job (id) ON DELETE CASCADE,
    created_at  BIGINT NOT NULL
);

-- Processes that work on jobs; beat_at is the database's own clock.
CREATE TABLE worker (
    id         TEXT PRIMARY KEY,
    version    TEXT NOT NULL,
    slots      BIGINT NOT NULL,
    started_at BIGINT NOT NULL,
    beat_at    BIGINT NOT NULL
);
