-- Times are microseconds since 1970. An owner is the id of an API key; it is empty where keys are off.

CREATE TABLE meshes (
    -- Order of arrival; what lists page by.
    seq        INTEGER PRIMARY KEY AUTOINCREMENT,
    owner      TEXT    NOT NULL,
    id         TEXT    NOT NULL,
    format     TEXT    NOT NULL,
    -- The unit of the coordinates, where the sender named one, and the factor that they are multiplied by.
    units      TEXT,
    scale      REAL    NOT NULL DEFAULT 1.0,
    bytes      INTEGER NOT NULL,
    candidates INTEGER NOT NULL,
    file_name  TEXT,
    created_at INTEGER NOT NULL,
    -- When it was last uploaded or asked for; what expiry counts from.
    used_at    INTEGER NOT NULL,
    report     TEXT    NOT NULL,
    UNIQUE (owner, id)
) STRICT;
-- Owners share the file of a mesh that each of them sent.
CREATE INDEX meshes_by_id ON meshes (id);
CREATE INDEX meshes_by_use ON meshes (used_at);
CREATE INDEX meshes_by_owner ON meshes (owner, seq);

-- Jobs that were submitted as one.
CREATE TABLE batches (
    id         TEXT    NOT NULL PRIMARY KEY, -- UUID version 7: sorts by time
    owner      TEXT    NOT NULL,
    label      TEXT,
    -- As many as were submitted; each of them may be forgotten by itself.
    jobs       INTEGER NOT NULL,
    created_at INTEGER NOT NULL
) STRICT;
CREATE INDEX batches_by_owner ON batches (owner, id);
CREATE INDEX batches_by_age ON batches (created_at);

CREATE TABLE jobs (
    id               TEXT    NOT NULL PRIMARY KEY, -- UUID version 7: sorts by time
    owner            TEXT    NOT NULL DEFAULT '',
    -- No foreign key: a mesh may be forgotten once all its jobs have ended.
    mesh_id          TEXT    NOT NULL,
    state            TEXT    NOT NULL
        CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    priority         TEXT    NOT NULL DEFAULT 'interactive'
        CHECK (priority IN ('interactive', 'batch')),
    attempt          INTEGER NOT NULL DEFAULT 1,
    revision         INTEGER NOT NULL DEFAULT 1,
    cancel_requested INTEGER NOT NULL DEFAULT 0,
    lease            TEXT,
    created_at       INTEGER NOT NULL,
    started_at       INTEGER,
    finished_at      INTEGER,
    batch_id         TEXT,
    batch_index      INTEGER CHECK ((batch_id IS NULL) = (batch_index IS NULL)),
    label            TEXT,
    request          TEXT    NOT NULL,
    progress         TEXT,
    problem          TEXT,
    -- Last, so that a statement that reads only the other columns never touches its pages.
    result           TEXT,
    CHECK ((state = 'running') = (lease IS NOT NULL)),
    CHECK ((state IN ('queued', 'running')) = (finished_at IS NULL))
) STRICT;
CREATE INDEX jobs_by_owner ON jobs (owner, id);
CREATE INDEX jobs_by_state ON jobs (owner, state, id);
CREATE INDEX jobs_by_mesh ON jobs (owner, mesh_id, id);
CREATE INDEX jobs_by_end ON jobs (finished_at) WHERE finished_at IS NOT NULL;
-- For turns: who waits in a class, how many of their jobs run, and when the last one began.
CREATE INDEX jobs_queued ON jobs (priority, owner, id) WHERE state = 'queued';
CREATE INDEX jobs_running ON jobs (owner) WHERE state = 'running';
CREATE INDEX jobs_by_start ON jobs (owner, started_at);
CREATE UNIQUE INDEX jobs_in_batch ON jobs (batch_id, batch_index) WHERE batch_id IS NOT NULL;
-- Holds all columns that the progress of a batch is computed from.
CREATE INDEX jobs_by_batch ON jobs (batch_id, state, id, started_at, finished_at)
    WHERE batch_id IS NOT NULL;

-- Every statement guards its own transition; this catches one that forgets to.
CREATE TRIGGER jobs_legal_transition
BEFORE UPDATE OF state ON jobs
WHEN OLD.state <> NEW.state AND NOT (
    (OLD.state = 'queued' AND NEW.state IN ('running', 'cancelled'))
    OR OLD.state = 'running'
)
BEGIN
    SELECT RAISE(ABORT, 'illegal state transition of a job');
END;

CREATE TRIGGER jobs_use_meshes AFTER INSERT ON jobs
BEGIN
    UPDATE meshes SET used_at = NEW.created_at WHERE owner = NEW.owner AND id = NEW.mesh_id;
END;

-- How many jobs are in each state, so that nothing has to count them.
CREATE TABLE job_counts (
    state TEXT    NOT NULL PRIMARY KEY,
    jobs  INTEGER NOT NULL DEFAULT 0
) STRICT, WITHOUT ROWID;
INSERT INTO job_counts (state) VALUES ('queued'), ('running'), ('succeeded'), ('failed'), ('cancelled');

CREATE TRIGGER jobs_come AFTER INSERT ON jobs
BEGIN
    UPDATE job_counts SET jobs = jobs + 1 WHERE state = NEW.state;
END;
CREATE TRIGGER jobs_go AFTER DELETE ON jobs
BEGIN
    UPDATE job_counts SET jobs = jobs - 1 WHERE state = OLD.state;
END;
CREATE TRIGGER jobs_turn AFTER UPDATE OF state ON jobs WHEN OLD.state <> NEW.state
BEGIN
    UPDATE job_counts SET jobs = jobs - 1 WHERE state = OLD.state;
    UPDATE job_counts SET jobs = jobs + 1 WHERE state = NEW.state;
END;

CREATE TABLE keys (
    -- The owner of everything that is sent with the key.
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

-- Jobs and batches that have expired: they are gone, rather than never here.
CREATE TABLE expired (
    id         TEXT    NOT NULL PRIMARY KEY,
    owner      TEXT    NOT NULL,
    expired_at INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
CREATE INDEX expired_by_age ON expired (expired_at);

-- The outbox: one delivery for each job that has ended and has a callback URL.
CREATE TABLE webhooks (
    job_id          TEXT    NOT NULL PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    url             TEXT    NOT NULL,
    -- Host and, where the URL has one, port. URLs are kept in normal form: nothing else is in that place.
    host            TEXT    NOT NULL GENERATED ALWAYS AS (
        substr(url, instr(url, '//') + 2, instr(substr(url, instr(url, '//') + 2) || '/', '/') - 1)
    ) STORED,
    state           TEXT    NOT NULL DEFAULT 'pending'
        CHECK (state IN ('pending', 'delivered', 'failed')),
    attempts        INTEGER NOT NULL DEFAULT 0,
    last_error      TEXT,
    last_attempt_at INTEGER,
    due_at          INTEGER,
    -- The token of the sender that has it, and until when.
    lease           TEXT,
    leased_until    INTEGER,
    CHECK ((state = 'pending') = (due_at IS NOT NULL)),
    CHECK ((lease IS NULL) = (leased_until IS NULL))
) STRICT;
CREATE INDEX webhooks_due ON webhooks (due_at, host) WHERE state = 'pending';

-- A trigger, so that a job and its delivery change together whoever ends the job.
CREATE TRIGGER jobs_callback
AFTER UPDATE OF state ON jobs
WHEN OLD.state IN ('queued', 'running') AND NEW.state NOT IN ('queued', 'running')
    AND json_valid(NEW.request) AND json_extract(NEW.request, '$.callback_url') IS NOT NULL
BEGIN
    INSERT INTO webhooks (job_id, url, due_at)
    VALUES (NEW.id, json_extract(NEW.request, '$.callback_url'), NEW.finished_at);
END;
