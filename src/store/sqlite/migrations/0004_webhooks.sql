-- The outbox: one delivery for each job that has ended and has a callback URL.
CREATE TABLE webhooks (
    job_id          TEXT    NOT NULL PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    url             TEXT    NOT NULL,
    -- Host and, where it has one, port. URLs are kept in normal form: nothing else is in that place.
    host            TEXT    NOT NULL GENERATED ALWAYS AS (
        substr(url, instr(url, '//') + 2, instr(substr(url, instr(url, '//') + 2) || '/', '/') - 1)
    ) STORED,
    state           TEXT    NOT NULL DEFAULT 'pending'
        CHECK (state IN ('pending', 'delivered', 'failed')),
    attempts        INTEGER NOT NULL DEFAULT 0,
    last_error      TEXT,
    last_attempt_at INTEGER,
    due_at          INTEGER,
    -- Whose turn it is, and until when.
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
