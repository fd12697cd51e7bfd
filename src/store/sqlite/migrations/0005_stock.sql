-- How many jobs are in each state, so that nobody has to count them.
CREATE TABLE stock (
    state TEXT    NOT NULL PRIMARY KEY,
    jobs  INTEGER NOT NULL DEFAULT 0
) STRICT, WITHOUT ROWID;
INSERT INTO stock (state) VALUES ('queued'), ('running'), ('succeeded'), ('failed'), ('cancelled');
UPDATE stock SET jobs = (SELECT count(*) FROM jobs WHERE jobs.state = stock.state);

CREATE TRIGGER jobs_come AFTER INSERT ON jobs
BEGIN
    UPDATE stock SET jobs = jobs + 1 WHERE state = NEW.state;
END;
CREATE TRIGGER jobs_go AFTER DELETE ON jobs
BEGIN
    UPDATE stock SET jobs = jobs - 1 WHERE state = OLD.state;
END;
CREATE TRIGGER jobs_turn AFTER UPDATE OF state ON jobs WHEN OLD.state <> NEW.state
BEGIN
    UPDATE stock SET jobs = jobs - 1 WHERE state = OLD.state;
    UPDATE stock SET jobs = jobs + 1 WHERE state = NEW.state;
END;

CREATE INDEX meshes_by_owner ON meshes (owner, seq);
