-- What is known of a ride besides its file: server/facts/. A job's date is that of its ride, or else of its upload.
ALTER TABLE ride ADD COLUMN
    facts JSON;
CREATE TABLE ride_tag (
    ride_id UUID NOT NULL REFERENCES ride (id) ON DELETE CASCADE,
    tag     TEXT NOT NULL,
    PRIMARY KEY (ride_id, tag)
);

CREATE INDEX ride_tag_tag ON ride_tag (tag, ride_id);
ALTER TABLE job ADD COLUMN dated_at BIGINT NOT NULL DEFAULT 0;
UPDATE job SET dated_at = created_at;
CREATE INDEX job_dated ON job (group_name, dated_at, id);
CREATE INDEX job_history ON job (group_name, bike, dated_at, id) WHERE state = 'succeeded' AND deleted_at IS NULL;
