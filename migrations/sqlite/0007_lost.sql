-- Whose fault it is that processes die: server/store/loss.rs.
ALTER TABLE job ADD COLUMN lost INTEGER NOT NULL DEFAULT 0;
ALTER TABLE job ADD COLUMN alone INTEGER;
CREATE INDEX job_lost ON job (lost) WHERE lost > 2;
