-- Microseconds since 1970 by the clock of this server, which all processes share. All times are of this kind.
CREATE FUNCTION now_us() RETURNS bigint LANGUAGE sql VOLATILE
    AS $$ SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::bigint $$;

-- The oldest program that still works with these tables, by the last migration that it knows. A migration that an
-- older program could not work with raises it.
CREATE TABLE compatibility (oldest bigint NOT NULL);
INSERT INTO compatibility VALUES (1);

-- Mesh files by the SHA-256 of their bytes, each once, in pieces.
CREATE TABLE files (
    digest bytea  NOT NULL PRIMARY KEY,
    bytes  bigint NOT NULL
);
CREATE TABLE pieces (
    digest bytea  NOT NULL REFERENCES files (digest) ON DELETE CASCADE,
    number bigint NOT NULL,
    data   bytea  NOT NULL,
    PRIMARY KEY (digest, number)
);
-- Most mesh files do not shrink, and those that do are not worth the time.
ALTER TABLE pieces ALTER COLUMN data SET STORAGE EXTERNAL;

CREATE TABLE meshes (
    -- Order of arrival; what lists page by.
    seq        bigint GENERATED ALWAYS AS IDENTITY,
    -- The id of the key that it was sent with; empty where keys are off.
    owner      text COLLATE "C" NOT NULL,
    id         text COLLATE "C" NOT NULL,
    -- The reference is what keeps a file that is being forgotten for one owner and added for another.
    digest     bytea  NOT NULL REFERENCES files (digest),
    format     text   NOT NULL,
    bytes      bigint NOT NULL,
    candidates bigint NOT NULL,
    file_name  text,
    created_at bigint NOT NULL,
    -- When it was last uploaded or asked for; what expiry counts from.
    used_at    bigint NOT NULL,
    report     text   NOT NULL,
    units      text,
    scale      double precision NOT NULL DEFAULT 1.0,
    PRIMARY KEY (owner, id)
);
CREATE INDEX meshes_by_id ON meshes (id);
CREATE INDEX meshes_by_file ON meshes (digest);
CREATE INDEX meshes_by_use ON meshes (used_at);
CREATE INDEX meshes_by_owner ON meshes (owner, seq);

-- Jobs that were submitted as one.
CREATE TABLE batches (
    id         text COLLATE "C" NOT NULL PRIMARY KEY, -- UUID version 7, as those of jobs
    owner      text COLLATE "C" NOT NULL,
    label      text,
    -- As many as were submitted; each of them may be forgotten by itself.
    jobs       bigint NOT NULL,
    created_at bigint NOT NULL
);
CREATE INDEX batches_by_owner ON batches (owner, id);
CREATE INDEX batches_by_age ON batches (created_at);

CREATE TABLE jobs (
    id               text COLLATE "C" NOT NULL PRIMARY KEY, -- UUID version 7: sorts by the time of its server
    -- Order of arrival, which does not depend on the clocks of servers; the order of the queue.
    seq              bigint GENERATED ALWAYS AS IDENTITY,
    owner            text COLLATE "C" NOT NULL,
    -- No foreign key: a mesh may be forgotten once all its jobs have ended.
    mesh_id          text COLLATE "C" NOT NULL,
    state            text   NOT NULL
        CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    priority         text   NOT NULL DEFAULT 'interactive' CHECK (priority IN ('interactive', 'batch')),
    -- The version of the settings in `request`: a worker leaves alone what only later ones can read.
    format           bigint NOT NULL DEFAULT 1,
    attempt          bigint NOT NULL DEFAULT 1,
    revision         bigint NOT NULL DEFAULT 1,
    cancel_requested boolean NOT NULL DEFAULT false,
    lease            text,
    leased_until     bigint,
    created_at       bigint NOT NULL,
    started_at       bigint,
    finished_at      bigint,
    label            text,
    -- JSON as it was written, which jsonb would not keep.
    request          text   NOT NULL,
    progress         text,
    problem          text,
    batch_id         text COLLATE "C",
    batch_index      bigint,
    CHECK ((state = 'running') = (lease IS NOT NULL)),
    CHECK ((lease IS NULL) = (leased_until IS NULL)),
    CHECK ((state IN ('queued', 'running')) = (finished_at IS NULL)),
    CHECK ((batch_id IS NULL) = (batch_index IS NULL))
)
-- A job is written three times within seconds: its page has room for that, and autovacuum does not wait long.
WITH (fillfactor = 60, autovacuum_vacuum_scale_factor = 0.02, autovacuum_vacuum_cost_delay = 0);
CREATE INDEX jobs_by_owner ON jobs (owner, id);
CREATE INDEX jobs_by_state ON jobs (owner, state, id);
CREATE INDEX jobs_by_mesh ON jobs (owner, mesh_id, id);
CREATE INDEX jobs_by_end ON jobs (finished_at) WHERE finished_at IS NOT NULL;
-- For turns: who waits in a class, how many of their jobs run, and when the last one began.
CREATE INDEX jobs_queued ON jobs (priority, owner, seq) WHERE state = 'queued';
CREATE INDEX jobs_running ON jobs (owner) WHERE state = 'running';
CREATE INDEX jobs_by_start ON jobs (owner, started_at);
CREATE UNIQUE INDEX jobs_in_batch ON jobs (batch_id, batch_index) WHERE batch_id IS NOT NULL;
-- Holds all columns that the progress of a batch is computed from.
CREATE INDEX jobs_by_batch ON jobs (batch_id, state, id, started_at, finished_at)
    WHERE batch_id IS NOT NULL;

-- Every statement guards its own transition; this catches one that forgets to.
CREATE FUNCTION refuse_transition() RETURNS trigger LANGUAGE plpgsql
    AS $$ BEGIN RAISE EXCEPTION 'illegal state transition of a job'; END $$;
CREATE TRIGGER jobs_legal_transition
BEFORE UPDATE OF state ON jobs FOR EACH ROW
WHEN (OLD.state <> NEW.state AND NOT (
    (OLD.state = 'queued' AND NEW.state IN ('running', 'cancelled'))
    OR OLD.state = 'running'
))
EXECUTE FUNCTION refuse_transition();

-- Results in pieces, apart from their jobs: a statement that only moves a job from state to state never touches them.
CREATE TABLE results (
    job_id text COLLATE "C" NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    number bigint NOT NULL,
    data   bytea  NOT NULL,
    PRIMARY KEY (job_id, number)
);

-- What was submitted under an Idempotency-Key.
CREATE TABLE submissions (
    owner       text COLLATE "C" NOT NULL,
    key         text COLLATE "C" NOT NULL,
    fingerprint bytea  NOT NULL,
    job         text   NOT NULL,
    created_at  bigint NOT NULL,
    PRIMARY KEY (owner, key)
);
CREATE INDEX submissions_by_age ON submissions (created_at);

-- Jobs and batches that have expired: they are gone, rather than never here.
CREATE TABLE expired (
    id         text COLLATE "C" NOT NULL PRIMARY KEY,
    owner      text   NOT NULL,
    expired_at bigint NOT NULL
);
CREATE INDEX expired_by_age ON expired (expired_at);

CREATE TABLE keys (
    -- The owner of everything that is sent with the key.
    id         text COLLATE "C" NOT NULL PRIMARY KEY,
    name       text   NOT NULL,
    -- SHA-256 of a secret of 256 random bits, which no guessing finds.
    hash       bytea  NOT NULL,
    created_at bigint NOT NULL,
    expires_at bigint,
    revoked_at bigint
);

-- The outbox: one delivery for each job that has ended and has a callback URL.
CREATE TABLE webhooks (
    job_id          text COLLATE "C" NOT NULL PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    url             text   NOT NULL,
    -- Host and, where the URL has one, port. URLs are kept in normal form: nothing else is in that place.
    host            text   NOT NULL GENERATED ALWAYS AS (split_part(split_part(url, '//', 2), '/', 1)) STORED,
    state           text   NOT NULL DEFAULT 'pending' CHECK (state IN ('pending', 'delivered', 'failed')),
    attempts        bigint NOT NULL DEFAULT 0,
    last_error      text,
    last_attempt_at bigint,
    due_at          bigint,
    -- The token of the sender that has it, and until when.
    lease           text,
    leased_until    bigint,
    CHECK ((state = 'pending') = (due_at IS NOT NULL)),
    CHECK ((lease IS NULL) = (leased_until IS NULL))
);
CREATE INDEX webhooks_due ON webhooks (due_at, host) WHERE state = 'pending';

-- A trigger, so that a job and its delivery change together whoever ends the job.
CREATE FUNCTION enter_callback() RETURNS trigger LANGUAGE plpgsql AS $$
DECLARE
    callback_url text := NEW.request::json ->> 'callback_url';
BEGIN
    IF callback_url IS NOT NULL THEN
        INSERT INTO webhooks (job_id, url, due_at) VALUES (NEW.id, callback_url, NEW.finished_at);
    END IF;
    RETURN NULL;
END $$;
CREATE TRIGGER jobs_callback
AFTER UPDATE OF state ON jobs FOR EACH ROW
WHEN (OLD.finished_at IS NULL AND NEW.finished_at IS NOT NULL AND NEW.request LIKE '%"callback_url"%')
EXECUTE FUNCTION enter_callback();
