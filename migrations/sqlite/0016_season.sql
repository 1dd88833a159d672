-- `veloid seed` of earlier versions made rides up, with 'season' in place of a file's SHA-256. They go, with all that belongs
-- to them, and so do bicycles that have no other. SQLite enforces no references while it migrates, so each table is named.
CREATE TABLE season_job AS
SELECT job.id, job.group_name, job.bike FROM job JOIN ride ON ride.id = job.ride_id WHERE ride.sha256 = 'season';

DELETE FROM trial WHERE job_id IN (SELECT id FROM season_job);
DELETE FROM result WHERE job_id IN (SELECT id FROM season_job);
DELETE FROM parameter WHERE job_id IN (SELECT id FROM season_job);
DELETE FROM idempotency_key WHERE job_id IN (SELECT id FROM season_job);
DELETE FROM repair WHERE job_id IN (SELECT id FROM season_job);
DELETE FROM job WHERE id IN (SELECT id FROM season_job);
DELETE FROM ride_tag WHERE ride_id IN (SELECT id FROM ride WHERE sha256 = 'season');
DELETE FROM ride_file WHERE ride_id IN (SELECT id FROM ride WHERE sha256 = 'season');
DELETE FROM ride WHERE sha256 = 'season';

DELETE FROM bike_told
WHERE EXISTS (SELECT 1 FROM season_job AS made WHERE made.group_name = bike_told.group_name AND made.bike = bike_told.bike)
    AND NOT EXISTS (SELECT 1 FROM job WHERE job.group_name = bike_told.group_name AND job.bike = bike_told.bike);
DELETE FROM bike
WHERE EXISTS (SELECT 1 FROM season_job AS made WHERE made.group_name = bike.group_name AND made.bike = bike.name)
    AND NOT EXISTS (SELECT 1 FROM job WHERE job.group_name = bike.group_name AND job.bike = bike.name);
DROP TABLE season_job;
