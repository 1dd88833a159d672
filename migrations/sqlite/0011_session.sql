-- Browsers that are signed in; of each only the SHA-256 of its token is kept.
CREATE TABLE session (
    id         BLOB PRIMARY KEY,
    sha256     TEXT NOT NULL UNIQUE,
    key_id     BLOB NOT NULL REFERENCES api_key (id),
    created_at INTEGER NOT NULL,
    expires_at INTEGER NOT NULL
) STRICT;
