-- Jobs, their events, their files, and the workers.
-- Times are microseconds since 1970, 0 for "not yet". JSON columns hold 'null' for "none".

CREATE TABLE jobs (
    id               TEXT PRIMARY KEY,               -- sorts by age
    state            TEXT NOT NULL
                     CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'canceled')),
    priority         INTEGER NOT NULL DEFAULT 0,     -- higher is claimed first
    tag              TEXT NOT NULL DEFAULT '',
    kind             TEXT NOT NULL,                  -- kind of mesh
    upload           TEXT NOT NULL,                  -- blob
    labels           TEXT NOT NULL DEFAULT '',       -- blob, or empty
    options          TEXT NOT NULL,                  -- JSON
    attempt          INTEGER NOT NULL DEFAULT 0,
    max_attempts     INTEGER NOT NULL,
    cancel_requested INTEGER NOT NULL DEFAULT 0,
    worker           TEXT NOT NULL DEFAULT '',       -- who runs it
    lease            TEXT NOT NULL DEFAULT '',       -- token of whoever may write
    lease_until      INTEGER NOT NULL DEFAULT 0,
    progress         TEXT NOT NULL DEFAULT 'null',   -- JSON
    engine           TEXT NOT NULL DEFAULT '',
    weights          TEXT NOT NULL DEFAULT '',
    device           TEXT NOT NULL DEFAULT '',
    metrics          TEXT NOT NULL DEFAULT 'null',   -- JSON
    error            TEXT NOT NULL DEFAULT 'null',   -- JSON
    created_at       INTEGER NOT NULL,
    started_at       INTEGER NOT NULL DEFAULT 0,
    finished_at      INTEGER NOT NULL DEFAULT 0,
    expires_at       INTEGER NOT NULL DEFAULT 0,
    expired          INTEGER NOT NULL DEFAULT 0,     -- its blobs are gone
    last_seq         INTEGER NOT NULL DEFAULT 0,     -- of its events
    revision         INTEGER NOT NULL DEFAULT 1      -- grows with every change
) STRICT, WITHOUT ROWID;

CREATE INDEX jobs_waiting ON jobs (priority DESC, id) WHERE state = 'queued';
CREATE INDEX jobs_leased ON jobs (lease_until) WHERE state = 'running';
CREATE INDEX jobs_expiring ON jobs (expires_at) WHERE expires_at > 0 AND expired = 0;
CREATE INDEX jobs_by_state ON jobs (state, id);
CREATE INDEX jobs_by_tag ON jobs (tag, id) WHERE tag <> '';

CREATE TABLE job_events (
    event_id INTEGER PRIMARY KEY AUTOINCREMENT,      -- never reused: streams resume by it
    job_id   TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    seq      INTEGER NOT NULL,
    kind     TEXT NOT NULL,
    data     TEXT NOT NULL,                          -- JSON
    at       INTEGER NOT NULL,
    UNIQUE (job_id, seq)
) STRICT;

CREATE TABLE artifacts (
    job_id     TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE,
    position   INTEGER NOT NULL,
    name       TEXT NOT NULL,
    media_type TEXT NOT NULL,
    bytes      INTEGER NOT NULL,
    sha256     TEXT NOT NULL,
    blob       TEXT NOT NULL,
    PRIMARY KEY (job_id, position),
    UNIQUE (job_id, name)
) STRICT, WITHOUT ROWID;

-- Every blob that must be kept; what is stored and not named here is an orphan.
CREATE TABLE blobs (
    name   TEXT PRIMARY KEY,
    job_id TEXT NOT NULL REFERENCES jobs (id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;

CREATE INDEX blobs_by_job ON blobs (job_id);

CREATE TABLE workers (
    id        TEXT PRIMARY KEY,
    pid       INTEGER NOT NULL,
    host      TEXT NOT NULL,
    device    TEXT NOT NULL,
    engine    TEXT NOT NULL,
    draining  INTEGER NOT NULL DEFAULT 0,
    last_seen INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
