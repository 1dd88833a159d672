-- Browsers that are signed in; of each only the SHA-256 of its token is kept.
CREATE TABLE session (
    id         UUID PRIMARY KEY,
    sha256     TEXT NOT NULL UNIQUE,
    key_id     UUID NOT NULL REFERENCES api_key (id),
    created_at BIGINT NOT NULL,
    expires_at BIGINT NOT NULL
);
