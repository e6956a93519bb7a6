-- The shop: machines, programs, what was sent where, what came back, who may do what.
-- Times are Unix milliseconds, hashes lower-case hex, flags 0/1. History rows are immutable: triggers refuse changes.

CREATE TABLE settings (key TEXT PRIMARY KEY, value TEXT NOT NULL);

-- ---- people
CREATE TABLE users (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  user TEXT NOT NULL UNIQUE,
  name TEXT NOT NULL,
  role TEXT NOT NULL CHECK (role IN ('viewer', 'operator', 'programmer', 'setter', 'administrator')),
  language TEXT NOT NULL DEFAULT 'en',
  password TEXT NOT NULL,
  must_change_password INTEGER NOT NULL DEFAULT 0,
  disabled INTEGER NOT NULL DEFAULT 0,
  failures INTEGER NOT NULL DEFAULT 0,
  locked_until_ms INTEGER NOT NULL DEFAULT 0,
  created_ms INTEGER NOT NULL,
  last_sign_in_ms INTEGER,
  removed_ms INTEGER
);
CREATE TABLE sessions (
  token_sha256 TEXT PRIMARY KEY,
  user_id INTEGER NOT NULL REFERENCES users (id),
  created_ms INTEGER NOT NULL,
  expires_ms INTEGER NOT NULL,
  address TEXT NOT NULL DEFAULT ''
);
CREATE INDEX sessions_user ON sessions (user_id);
CREATE TABLE audit (
  id INTEGER PRIMARY KEY,
  at_ms INTEGER NOT NULL,
  user TEXT NOT NULL,
  address TEXT NOT NULL,
  action TEXT NOT NULL,
  subject TEXT NOT NULL,
  detail TEXT NOT NULL,
  previous_hash TEXT NOT NULL,
  hash TEXT NOT NULL
);
CREATE INDEX audit_subject ON audit (subject);

-- ---- machines
CREATE TABLE machines (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  profile TEXT NOT NULL,
  toml TEXT NOT NULL DEFAULT '',
  config_hash TEXT NOT NULL DEFAULT '',
  offsets_json TEXT NOT NULL DEFAULT '{}',
  offsets_version INTEGER NOT NULL DEFAULT 0,
  offsets_at_ms INTEGER,
  parts_required INTEGER NOT NULL DEFAULT 0,
  software TEXT NOT NULL DEFAULT '',
  boot_id TEXT NOT NULL DEFAULT '',
  last_seen_ms INTEGER,
  live_json TEXT NOT NULL DEFAULT '',
  created_ms INTEGER NOT NULL,
  removed_ms INTEGER
);
CREATE UNIQUE INDEX machines_name ON machines (name) WHERE removed_ms IS NULL;
CREATE TABLE enrolment_tokens (
  secret_sha256 TEXT PRIMARY KEY,
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  created_by TEXT NOT NULL,
  created_ms INTEGER NOT NULL,
  expires_ms INTEGER NOT NULL,
  used_ms INTEGER
);
CREATE TABLE certificates (
  serial TEXT NOT NULL,
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  issued_ms INTEGER NOT NULL,
  revoked_ms INTEGER,
  PRIMARY KEY (machine_id, serial)
);
CREATE TABLE residents (
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  name TEXT NOT NULL,
  sha256 TEXT NOT NULL,
  bytes INTEGER NOT NULL,
  since_ms INTEGER,
  selected INTEGER NOT NULL DEFAULT 0,
  reported_ms INTEGER NOT NULL,
  PRIMARY KEY (machine_id, name)
);
CREATE TABLE tool_life (
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  tool TEXT NOT NULL,
  unit TEXT NOT NULL,
  used REAL NOT NULL,
  life REAL NOT NULL,
  at_ms INTEGER NOT NULL,
  PRIMARY KEY (machine_id, tool)
);

-- ---- programs
CREATE TABLE folders (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  path TEXT NOT NULL UNIQUE
);
CREATE TABLE programs (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  folder_id INTEGER NOT NULL REFERENCES folders (id),
  name TEXT NOT NULL,
  created_ms INTEGER NOT NULL,
  removed_ms INTEGER
);
CREATE UNIQUE INDEX programs_name ON programs (folder_id, name) WHERE removed_ms IS NULL;
CREATE TABLE blobs (
  sha256 TEXT PRIMARY KEY,
  bytes INTEGER NOT NULL,
  lines INTEGER NOT NULL,
  longest_line INTEGER NOT NULL,
  encoding TEXT NOT NULL,
  line_ends TEXT NOT NULL,
  nul_bytes INTEGER NOT NULL,
  has_percent INTEGER NOT NULL,
  created_ms INTEGER NOT NULL
);
CREATE TABLE revisions (
  program_id INTEGER NOT NULL REFERENCES programs (id),
  number INTEGER NOT NULL,
  sha256 TEXT NOT NULL REFERENCES blobs (sha256),
  by_user TEXT NOT NULL,
  at_ms INTEGER NOT NULL,
  note TEXT NOT NULL,
  origin TEXT NOT NULL,
  PRIMARY KEY (program_id, number)
);
CREATE INDEX revisions_sha ON revisions (sha256);
CREATE TABLE releases (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  program_id INTEGER NOT NULL,
  revision INTEGER NOT NULL,
  by_user TEXT NOT NULL,
  at_ms INTEGER NOT NULL,
  why TEXT NOT NULL,
  withdrawn_by TEXT,
  withdrawn_ms INTEGER,
  withdrawn_why TEXT,
  FOREIGN KEY (program_id, revision) REFERENCES revisions (program_id, number)
);
CREATE UNIQUE INDEX releases_current ON releases (program_id) WHERE withdrawn_ms IS NULL;
CREATE TABLE checks (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  sha256 TEXT NOT NULL REFERENCES blobs (sha256),
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  config_hash TEXT NOT NULL,
  offsets_version INTEGER NOT NULL,
  checker TEXT NOT NULL,
  ok INTEGER NOT NULL,
  result_json TEXT NOT NULL,
  at_ms INTEGER NOT NULL,
  UNIQUE (sha256, machine_id, config_hash, offsets_version, checker)
);

-- ---- on the way to machines
CREATE TABLE distributions (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  program_id INTEGER NOT NULL,
  revision INTEGER NOT NULL,
  by_user TEXT NOT NULL,
  at_ms INTEGER NOT NULL,
  FOREIGN KEY (program_id, revision) REFERENCES revisions (program_id, number)
);
CREATE TABLE transfers (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  distribution_id INTEGER REFERENCES distributions (id),
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  program_id INTEGER NOT NULL,
  revision INTEGER NOT NULL,
  name TEXT NOT NULL,
  sha256 TEXT NOT NULL REFERENCES blobs (sha256),
  kind TEXT NOT NULL CHECK (kind IN ('put', 'drip')),
  state TEXT NOT NULL CHECK (state IN ('queued', 'checking', 'sending', 'waiting', 'done', 'failed', 'cancelled')),
  bytes INTEGER NOT NULL DEFAULT 0,
  total INTEGER NOT NULL,
  reason TEXT NOT NULL DEFAULT '',
  by_user TEXT NOT NULL,
  created_ms INTEGER NOT NULL,
  started_ms INTEGER,
  ended_ms INTEGER,
  FOREIGN KEY (program_id, revision) REFERENCES revisions (program_id, number)
);
CREATE INDEX transfers_open ON transfers (machine_id) WHERE ended_ms IS NULL;

-- ---- what machines reported. `events` is the raw truth, everything below it can be computed again from it.
CREATE TABLE spools (
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  spool TEXT NOT NULL,
  last_sequence INTEGER NOT NULL,
  first_seen_ms INTEGER NOT NULL,
  PRIMARY KEY (machine_id, spool)
);
CREATE TABLE events (
  machine_id INTEGER NOT NULL,
  spool TEXT NOT NULL,
  sequence INTEGER NOT NULL,
  at_ms INTEGER NOT NULL,
  received_ms INTEGER NOT NULL,
  kind TEXT NOT NULL,
  body TEXT NOT NULL,
  PRIMARY KEY (machine_id, spool, sequence),
  FOREIGN KEY (machine_id, spool) REFERENCES spools (machine_id, spool)
);
CREATE TABLE event_gaps (
  machine_id INTEGER NOT NULL,
  spool TEXT NOT NULL,
  first_sequence INTEGER NOT NULL,
  last_sequence INTEGER NOT NULL,
  at_ms INTEGER NOT NULL,
  PRIMARY KEY (machine_id, spool, first_sequence)
);
CREATE TABLE parts (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL,
  spool TEXT NOT NULL,
  sequence INTEGER NOT NULL,
  at_ms INTEGER NOT NULL,
  program TEXT NOT NULL,
  sha256 TEXT NOT NULL,
  machine_count INTEGER NOT NULL,
  machine_total INTEGER NOT NULL,
  cycle_s REAL NOT NULL,
  UNIQUE (machine_id, spool, sequence),
  FOREIGN KEY (machine_id, spool, sequence) REFERENCES events (machine_id, spool, sequence)
);
CREATE INDEX parts_at ON parts (machine_id, at_ms);
CREATE TABLE runs (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL,
  spool TEXT NOT NULL,
  run INTEGER NOT NULL,
  program TEXT NOT NULL,
  sha256 TEXT NOT NULL,
  started_ms INTEGER,
  ended_ms INTEGER,
  outcome TEXT NOT NULL DEFAULT '',
  run_s REAL,
  cutting_s REAL
);
CREATE INDEX runs_run ON runs (machine_id, spool, run);
CREATE TABLE alarms (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL,
  spool TEXT NOT NULL,
  sequence INTEGER NOT NULL,
  alarm INTEGER NOT NULL,
  code TEXT NOT NULL,
  text_en TEXT NOT NULL,
  text_zh TEXT NOT NULL,
  line INTEGER NOT NULL,
  column_number INTEGER NOT NULL,
  program TEXT NOT NULL,
  block TEXT NOT NULL,
  raised_ms INTEGER NOT NULL,
  cleared_ms INTEGER,
  UNIQUE (machine_id, spool, sequence)
);
CREATE INDEX alarms_raised ON alarms (raised_ms);
CREATE INDEX alarms_active ON alarms (machine_id) WHERE cleared_ms IS NULL;
CREATE TABLE state_intervals (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  state TEXT NOT NULL,
  mode TEXT NOT NULL,
  source TEXT NOT NULL CHECK (source IN ('machine', 'server')),
  from_ms INTEGER NOT NULL,
  to_ms INTEGER
);
CREATE INDEX state_intervals_from ON state_intervals (machine_id, from_ms);
CREATE UNIQUE INDEX state_intervals_open ON state_intervals (machine_id) WHERE to_ms IS NULL;
CREATE TABLE offset_changes (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL,
  spool TEXT NOT NULL,
  sequence INTEGER NOT NULL,
  at_ms INTEGER NOT NULL,
  what TEXT NOT NULL,
  before_value REAL NOT NULL,
  after_value REAL NOT NULL,
  origin TEXT NOT NULL,
  UNIQUE (machine_id, spool, sequence)
);
CREATE TABLE offsets (
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  what TEXT NOT NULL,
  value REAL NOT NULL,
  at_ms INTEGER NOT NULL,
  PRIMARY KEY (machine_id, what)
);

-- ---- what has happened stays
CREATE TRIGGER audit_kept_update BEFORE UPDATE ON audit BEGIN SELECT RAISE(ABORT, 'audit rows are immutable'); END;
CREATE TRIGGER audit_kept_delete BEFORE DELETE ON audit BEGIN SELECT RAISE(ABORT, 'audit rows are immutable'); END;
CREATE TRIGGER events_kept_update BEFORE UPDATE ON events BEGIN SELECT RAISE(ABORT, 'events are immutable'); END;
CREATE TRIGGER events_kept_delete BEFORE DELETE ON events BEGIN SELECT RAISE(ABORT, 'events are immutable'); END;
CREATE TRIGGER parts_kept_update BEFORE UPDATE ON parts BEGIN SELECT RAISE(ABORT, 'part counts are immutable'); END;
CREATE TRIGGER parts_kept_delete BEFORE DELETE ON parts BEGIN SELECT RAISE(ABORT, 'part counts are immutable'); END;
CREATE TRIGGER revisions_kept_update BEFORE UPDATE ON revisions BEGIN SELECT RAISE(ABORT, 'revisions are immutable'); END;
CREATE TRIGGER revisions_kept_delete BEFORE DELETE ON revisions BEGIN SELECT RAISE(ABORT, 'revisions are immutable'); END;
CREATE TRIGGER blobs_kept_update BEFORE UPDATE ON blobs BEGIN SELECT RAISE(ABORT, 'blobs are immutable'); END;
CREATE TRIGGER blobs_kept_delete BEFORE DELETE ON blobs BEGIN SELECT RAISE(ABORT, 'blobs are immutable'); END;
