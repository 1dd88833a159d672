-- When a job's work comes: server/store/turn.rs.
ALTER TABLE job ADD COLUMN turn BIGINT NOT NULL DEFAULT 0;
