-- Files of the rides that have several. Such a ride's own sha256 stands for theirs, its bytes are their sum.
CREATE TABLE ride_file (
    ride_id BLOB NOT NULL REFERENCES ride (id) ON DELETE CASCADE,
    number  INTEGER NOT NULL,
    sha256  TEXT NOT NULL,
    name    TEXT NOT NULL,
    bytes   INTEGER NOT NULL,
    PRIMARY KEY (ride_id, number)
) STRICT;
