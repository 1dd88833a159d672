-- The effects of its bicycle that a job's ride was fitted with again (methods `course` of its parameters), as AXLE.EFFECT with commas
-- between them. Null of jobs that were not.
ALTER TABLE job ADD COLUMN refitted TEXT;
