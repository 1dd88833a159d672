-- What is deleted is marked first, and erased once the mark is old enough: server/erasure/. A ride is deleted when all
-- of its jobs are.
ALTER TABLE job ADD COLUMN deleted_at BIGINT;
ALTER TABLE bike ADD COLUMN deleted_at BIGINT;
CREATE INDEX job_deleted_of ON job (group_name, id) WHERE deleted_at IS NOT NULL;
CREATE INDEX job_deleted ON job (id, deleted_at) WHERE deleted_at IS NOT NULL;
CREATE INDEX idempotency_key_job ON idempotency_key (job_id);
CREATE INDEX ride_sha256 ON ride (sha256);
CREATE INDEX ride_file_sha256 ON ride_file (sha256);

-- Who did what, and when; rows are only ever added. The key is that of an actor who is one.
CREATE TABLE audit (
    id         UUID PRIMARY KEY,
    group_name TEXT NOT NULL,
    actor      TEXT NOT NULL CHECK (actor IN ('key', 'keyless', 'server', 'command')),
    key_id     UUID,
    action     TEXT NOT NULL,
    subject    TEXT NOT NULL,
    done_at    BIGINT NOT NULL
);

CREATE INDEX audit_group ON audit (group_name, id);
