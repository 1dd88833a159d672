-- The one installation that this database and its store of raw files belong to: server/installation.rs.
CREATE TABLE installation (
    single     INTEGER PRIMARY KEY CHECK (single = 1),
    id         BLOB NOT NULL,
    created_at INTEGER NOT NULL
) STRICT;

-- Raw files whose last ride was erased, to be removed from the store: server/erasure/prune.rs.
CREATE TABLE erased_file (
    sha256    TEXT PRIMARY KEY,
    erased_at INTEGER NOT NULL
) STRICT;

CREATE INDEX erased_file_at ON erased_file (erased_at);
