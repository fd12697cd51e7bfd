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

ALTER TABLE jobs ADD COLUMN batch_id TEXT;
ALTER TABLE jobs ADD COLUMN batch_index INTEGER
    CHECK ((batch_id IS NULL) = (batch_index IS NULL));
CREATE UNIQUE INDEX jobs_in_batch ON jobs (batch_id, batch_index) WHERE batch_id IS NOT NULL;
-- Holds all that the progress of a batch is made of.
CREATE INDEX jobs_by_batch ON jobs (batch_id, state, id, started_at, finished_at)
    WHERE batch_id IS NOT NULL;
