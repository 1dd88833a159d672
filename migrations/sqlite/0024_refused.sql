-- Uploads that were refused, for a week: the file's name and the bicycle's as far as they arrived, and the reason.
CREATE TABLE refused_upload (
    id         BLOB PRIMARY KEY,
    group_name TEXT NOT NULL,
    actor      TEXT NOT NULL CHECK (actor IN ('key', 'keyless')),
    key_id     BLOB,
    file       TEXT,
    bike       TEXT,
    kind       TEXT NOT NULL,
    status     INTEGER NOT NULL,
    detail     TEXT NOT NULL,
    refused_at INTEGER NOT NULL
) STRICT;

CREATE INDEX refused_upload_group ON refused_upload (group_name, id);
