-- Whose fault it is that processes die: server/store/loss.rs.
ALTER TABLE job ADD COLUMN lost BIGINT NOT NULL DEFAULT 0;
ALTER TABLE job ADD COLUMN alone BIGINT;
CREATE INDEX job_lost ON job (lost) WHERE lost > 2;
