-- The ride that a job's report proposes next, where several sets of effects explain its ride equally.
CREATE TABLE proposal (
    job_id    UUID PRIMARY KEY REFERENCES job (id) ON DELETE CASCADE,
    next_ride JSON NOT NULL
);

CREATE INDEX job_study ON job (group_name, bike, id) WHERE study IS NOT NULL;
