-- The ride that a job's report proposes next, where several sets of effects explain its ride equally.
CREATE TABLE proposal (
    job_id    BLOB PRIMARY KEY REFERENCES job (id) ON DELETE CASCADE,
    next_ride TEXT NOT NULL
) STRICT;

CREATE INDEX job_study ON job (group_name, bike, id) WHERE study IS NOT NULL;
