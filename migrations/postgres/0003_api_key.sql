-- Keys that open the server; of each only the SHA-256 is kept. Null limits are the server's own.
CREATE TABLE api_key (
    id                  UUID PRIMARY KEY,
    sha256              TEXT NOT NULL UNIQUE,
    name                TEXT NOT NULL,
    group_name          TEXT NOT NULL,
    scopes              TEXT NOT NULL,
    max_upload_bytes    BIGINT,
    requests_per_minute BIGINT,
    unfinished_jobs     BIGINT,
    created_at          BIGINT NOT NULL,
    expires_at          BIGINT,
    last_used_at        BIGINT,
    revoked_at          BIGINT
);
