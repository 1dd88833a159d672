-- Why a job that succeeded gave neither stiffness nor damping of any axle, for lists. Null of jobs before this version.
ALTER TABLE job ADD COLUMN no_result TEXT;
