-- The jobs whose rides a job identifies as one, as a list of ids; null of the identification of one ride.
ALTER TABLE job ADD COLUMN
    study JSON;
