-- What was done to a bicycle, and on which day (the beginning of it, UTC). What is deleted with the bicycle is marked with the
-- same time as it is.
CREATE TABLE bike_event (
    id         UUID PRIMARY KEY,
    group_name TEXT NOT NULL,
    bike       TEXT NOT NULL,
    day        BIGINT NOT NULL,
    text       TEXT NOT NULL,
    created_at BIGINT NOT NULL,
    deleted_at BIGINT,
    FOREIGN KEY (group_name, bike) REFERENCES bike (group_name, name) ON DELETE CASCADE
);

CREATE INDEX bike_event_bike ON bike_event (group_name, bike, day);
CREATE INDEX bike_event_deleted ON bike_event (deleted_at) WHERE deleted_at IS NOT NULL;
