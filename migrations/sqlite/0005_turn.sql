-- When a job's work comes: server/store/turn.rs.
ALTER TABLE job ADD COLUMN turn INTEGER NOT NULL DEFAULT 0;
CREATE INDEX job_turn ON job (turn) WHERE finished_at IS NULL;
CREATE INDEX job_turn_of ON job (group_name, key_id, turn) WHERE finished_at IS NULL;
