-- Who is told when jobs end and bicycles change: server/webhooks/. Events stand with blanks between. The secret is shared
-- with the receiver and has to be readable.
CREATE TABLE webhook (
    id         BLOB PRIMARY KEY,
    group_name TEXT NOT NULL,
    url        TEXT NOT NULL,
    events     TEXT NOT NULL,
    secret     TEXT NOT NULL,
    created_at INTEGER NOT NULL,
    -- How the last attempt at a delivery ended, in words, and when.
    outcome    TEXT,
    tried_at   INTEGER
) STRICT;

CREATE INDEX webhook_group ON webhook (group_name, id);

-- What was told last of each bicycle's parameters.
CREATE TABLE bike_told (
    group_name TEXT NOT NULL,
    bike       TEXT NOT NULL,
    axle       TEXT NOT NULL,
    name       TEXT NOT NULL,
    kind       TEXT NOT NULL,
    PRIMARY KEY (group_name, bike, axle, name),
    FOREIGN KEY (group_name, bike) REFERENCES bike (group_name, name) ON DELETE CASCADE
) STRICT;
