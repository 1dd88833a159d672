-- Keys that open the server; of each only the SHA-256 is kept. Null limits are the server's own.
CREATE TABLE api_key (
    id                  BLOB PRIMARY KEY,
    sha256              TEXT NOT NULL UNIQUE,
    name                TEXT NOT NULL,
    group_name          TEXT NOT NULL,
    scopes              TEXT NOT NULL,
    max_upload_bytes    INTEGER,
    requests_per_minute INTEGER,
    unfinished_jobs     INTEGER,
    created_at          INTEGER NOT NULL,
    expires_at          INTEGER,
    last_used_at        INTEGER,
    revoked_at          INTEGER
) STRICT;
