-- Whose key a mesh or a job was sent with; empty where keys are off.
CREATE TABLE owned_meshes (
    seq        INTEGER PRIMARY KEY AUTOINCREMENT,
    owner      TEXT    NOT NULL,
    id         TEXT    NOT NULL,
    format     TEXT    NOT NULL,
    bytes      INTEGER NOT NULL,
    candidates INTEGER NOT NULL,
    file_name  TEXT,
    created_at INTEGER NOT NULL,
    -- Last uploaded or asked for; what expiry counts from.
    used_at    INTEGER NOT NULL,
    report     TEXT    NOT NULL,
    units      TEXT,
    scale      REAL    NOT NULL DEFAULT 1.0,
    UNIQUE (owner, id)
) STRICT;
INSERT INTO owned_meshes
    SELECT seq, '', id, format, bytes, candidates, file_name, created_at, created_at, report, units, scale
    FROM meshes;
DROP TABLE meshes;
ALTER TABLE owned_meshes RENAME TO meshes;
-- Owners share the file of a mesh that each of them sent.
CREATE INDEX meshes_by_id ON meshes (id);
CREATE INDEX meshes_by_use ON meshes (used_at);

ALTER TABLE jobs ADD COLUMN owner TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN priority TEXT NOT NULL DEFAULT 'interactive'
    CHECK (priority IN ('interactive', 'batch'));
DROP INDEX jobs_by_state;
DROP INDEX jobs_by_mesh;
CREATE INDEX jobs_by_owner ON jobs (owner, id);
CREATE INDEX jobs_by_state ON jobs (owner, state, id);
CREATE INDEX jobs_by_mesh ON jobs (owner, mesh_id, id);
CREATE INDEX jobs_by_end ON jobs (finished_at) WHERE finished_at IS NOT NULL;
-- Whose turn it is: who waits in a class, how many of theirs run, and when the last one began.
CREATE INDEX jobs_queued ON jobs (priority, owner, id) WHERE state = 'queued';
CREATE INDEX jobs_running ON jobs (owner) WHERE state = 'running';
CREATE INDEX jobs_by_start ON jobs (owner, started_at);

CREATE TRIGGER jobs_use_meshes AFTER INSERT ON jobs
BEGIN
    UPDATE meshes SET used_at = NEW.created_at WHERE owner = NEW.owner AND id = NEW.mesh_id;
END;

CREATE TABLE keys (
    -- The owner of what is sent with the key.
    id         TEXT    NOT NULL PRIMARY KEY,
    name       TEXT    NOT NULL,
    -- SHA-256 of a secret of 256 random bits, which no guessing finds.
    hash       BLOB    NOT NULL,
    created_at INTEGER NOT NULL,
    expires_at INTEGER,
    revoked_at INTEGER
) STRICT;

-- What was submitted under an Idempotency-Key.
CREATE TABLE submissions (
    owner       TEXT    NOT NULL,
    key         TEXT    NOT NULL,
    fingerprint BLOB    NOT NULL,
    job         TEXT    NOT NULL,
    created_at  INTEGER NOT NULL,
    PRIMARY KEY (owner, key)
) STRICT, WITHOUT ROWID;
CREATE INDEX submissions_by_age ON submissions (created_at);

-- Jobs that expired: gone, rather than never here.
CREATE TABLE expired (
    id         TEXT    NOT NULL PRIMARY KEY,
    owner      TEXT    NOT NULL,
    expired_at INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
CREATE INDEX expired_by_age ON expired (expired_at);
