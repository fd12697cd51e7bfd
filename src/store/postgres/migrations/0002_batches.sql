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

ALTER TABLE jobs ADD COLUMN batch_id text COLLATE "C", ADD COLUMN batch_index bigint,
    ADD CHECK ((batch_id IS NULL) = (batch_index IS NULL));
CREATE UNIQUE INDEX jobs_in_batch ON jobs (batch_id, batch_index) WHERE batch_id IS NOT NULL;
-- Holds all that the progress of a batch is made of.
CREATE INDEX jobs_by_batch ON jobs (batch_id, state, id, started_at, finished_at)
    WHERE batch_id IS NOT NULL;
