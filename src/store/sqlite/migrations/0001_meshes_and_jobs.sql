CREATE TABLE meshes (
    -- Order of arrival; what lists page by.
    seq        INTEGER PRIMARY KEY AUTOINCREMENT,
    id         TEXT    NOT NULL UNIQUE,
    format     TEXT    NOT NULL,
    bytes      INTEGER NOT NULL,
    candidates INTEGER NOT NULL,
    file_name  TEXT,
    created_at INTEGER NOT NULL, -- microseconds since 1970, as all times here
    report     TEXT    NOT NULL
) STRICT;

CREATE TABLE jobs (
    id               TEXT    NOT NULL PRIMARY KEY, -- UUID version 7: sorts by time
    -- No foreign key: a mesh may be forgotten once all its jobs have ended.
    mesh_id          TEXT    NOT NULL,
    state            TEXT    NOT NULL
        CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    attempt          INTEGER NOT NULL DEFAULT 1,
    revision         INTEGER NOT NULL DEFAULT 1,
    cancel_requested INTEGER NOT NULL DEFAULT 0,
    lease            TEXT,
    created_at       INTEGER NOT NULL,
    started_at       INTEGER,
    finished_at      INTEGER,
    label            TEXT,
    request          TEXT    NOT NULL,
    progress         TEXT,
    problem          TEXT,
    -- Last, so that what reads only the other columns never touches its pages.
    result           TEXT,
    CHECK ((state = 'running') = (lease IS NOT NULL)),
    CHECK ((state IN ('queued', 'running')) = (finished_at IS NULL))
) STRICT;

CREATE INDEX jobs_by_state ON jobs (state, id);
CREATE INDEX jobs_by_mesh ON jobs (mesh_id, id);

-- Every statement guards its own transition; this catches the one that forgets to.
CREATE TRIGGER jobs_legal_transition
BEFORE UPDATE OF state ON jobs
WHEN OLD.state <> NEW.state AND NOT (
    (OLD.state = 'queued' AND NEW.state IN ('running', 'cancelled'))
    OR OLD.state = 'running'
)
BEGIN
    SELECT RAISE(ABORT, 'illegal state transition of a job');
END;
