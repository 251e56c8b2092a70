-- A job names its input files by role. What it had before were a mesh and perhaps labels, of which
-- neither digest nor length was kept: '' and 0 stand for "not known".

CREATE TABLE job_inputs (
    job_id   TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    position INTEGER NOT NULL,
    role     TEXT NOT NULL,                          -- mesh, labels
    name     TEXT NOT NULL DEFAULT '',               -- as the client gave it
    kind     TEXT NOT NULL DEFAULT '',               -- kind of mesh
    sha256   TEXT NOT NULL DEFAULT '',
    bytes    INTEGER NOT NULL DEFAULT 0,
    blob     TEXT NOT NULL,
    PRIMARY KEY (job_id, position)
) STRICT, WITHOUT ROWID;

INSERT INTO job_inputs (job_id, position, role, kind, blob)
    SELECT id, 0, 'mesh', kind, upload FROM jobs;
INSERT INTO job_inputs (job_id, position, role, blob)
    SELECT id, 1, 'labels', labels FROM jobs WHERE labels <> '';

ALTER TABLE jobs DROP COLUMN kind;
ALTER TABLE jobs DROP COLUMN upload;
ALTER TABLE jobs DROP COLUMN labels;

-- What a worker computes with.
ALTER TABLE workers ADD COLUMN weights TEXT NOT NULL DEFAULT '';
ALTER TABLE workers ADD COLUMN threads INTEGER NOT NULL DEFAULT 0;
