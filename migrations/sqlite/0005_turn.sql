-- When a job's work comes: server/store/turn.rs.
ALTER TABLE job ADD COLUMN turn INTEGER NOT NULL DEFAULT 0;
