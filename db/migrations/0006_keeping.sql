-- Keeping: who may do what where, screens that only look, guessing, alarm rules and their messages, backups.

-- ---- people
CREATE TABLE machine_groups (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL UNIQUE
);
CREATE TABLE machine_group_members (
  group_id INTEGER NOT NULL REFERENCES machine_groups (id),
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  PRIMARY KEY (group_id, machine_id)
);
-- What one person may do beyond, or not do in spite of, the shop-wide role: on one machine, one group, or everywhere.
CREATE TABLE grants (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  user_id INTEGER NOT NULL REFERENCES users (id),
  machine_id INTEGER REFERENCES machines (id),
  group_id INTEGER REFERENCES machine_groups (id),
  role TEXT NOT NULL DEFAULT '' CHECK (role IN ('', 'operator', 'programmer', 'setter', 'administrator')),
  action TEXT NOT NULL DEFAULT '',
  allow INTEGER NOT NULL DEFAULT 1,
  CHECK ((role = '') <> (action = '')),
  CHECK (allow = 1 OR action <> '')
);
CREATE INDEX grants_user ON grants (user_id);
CREATE TABLE view_tokens (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  token_sha256 TEXT NOT NULL UNIQUE,
  by_user TEXT NOT NULL,
  created_ms INTEGER NOT NULL,
  expires_ms INTEGER,
  last_used_ms INTEGER,
  revoked_ms INTEGER
);
CREATE TABLE sign_in_failures (
  address TEXT PRIMARY KEY,
  failures INTEGER NOT NULL,
  locked_until_ms INTEGER NOT NULL,
  last_ms INTEGER NOT NULL
);
ALTER TABLE sessions ADD COLUMN last_used_ms INTEGER NOT NULL DEFAULT 0;
-- Who a person is at the sign-in provider (issuer and subject); empty: signs in with a password here.
ALTER TABLE users ADD COLUMN external TEXT NOT NULL DEFAULT '';
CREATE UNIQUE INDEX users_external ON users (external) WHERE external <> '';

-- ---- alarm rules
CREATE TABLE alarm_rules (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  machine_id INTEGER REFERENCES machines (id),
  group_id INTEGER REFERENCES machine_groups (id),
  code TEXT NOT NULL DEFAULT '',
  after_s INTEGER NOT NULL DEFAULT 0,
  email TEXT NOT NULL DEFAULT '',
  webhook TEXT NOT NULL DEFAULT '',
  escalate_after_s INTEGER NOT NULL DEFAULT 0,
  escalate_email TEXT NOT NULL DEFAULT '',
  escalate_webhook TEXT NOT NULL DEFAULT '',
  again_after_s INTEGER NOT NULL DEFAULT 300,
  since_alarm INTEGER NOT NULL DEFAULT 0,
  enabled INTEGER NOT NULL DEFAULT 1,
  removed_ms INTEGER
);
-- One event of one rule on one machine and code: as long as the alarm stays, or comes back soon, it is the same one.
CREATE TABLE alarm_events (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  rule_id INTEGER NOT NULL REFERENCES alarm_rules (id),
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  code TEXT NOT NULL,
  alarm_id INTEGER NOT NULL,
  first_ms INTEGER NOT NULL,
  last_ms INTEGER NOT NULL,
  times INTEGER NOT NULL DEFAULT 1,
  cleared_ms INTEGER,
  acknowledged_ms INTEGER,
  acknowledged_by TEXT NOT NULL DEFAULT '',
  acknowledged_note TEXT NOT NULL DEFAULT '',
  escalated_ms INTEGER
);
CREATE INDEX alarm_events_open ON alarm_events (rule_id, machine_id, code, last_ms);
CREATE TABLE notices (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  event_id INTEGER NOT NULL REFERENCES alarm_events (id),
  kind TEXT NOT NULL CHECK (kind IN ('email', 'webhook')),
  step TEXT NOT NULL CHECK (step IN ('first', 'escalation', 'cleared', 'test')),
  target TEXT NOT NULL,
  body TEXT NOT NULL,
  state TEXT NOT NULL CHECK (state IN ('waiting', 'sent', 'failed')),
  attempts INTEGER NOT NULL DEFAULT 0,
  next_ms INTEGER NOT NULL,
  sent_ms INTEGER,
  problem TEXT NOT NULL DEFAULT ''
);
CREATE INDEX notices_waiting ON notices (next_ms) WHERE state = 'waiting';

-- ---- backups that were made and restored
CREATE TABLE backups (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  file TEXT NOT NULL,
  kind TEXT NOT NULL CHECK (kind IN ('server', 'machine')),
  machine_id INTEGER,
  sha256 TEXT NOT NULL,
  bytes INTEGER NOT NULL,
  by_user TEXT NOT NULL,
  at_ms INTEGER NOT NULL,
  removed_ms INTEGER
);

-- ---- what the retention has taken out of `events`, and where it is now
CREATE TABLE event_archives (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  file TEXT NOT NULL,
  sha256 TEXT NOT NULL,
  events INTEGER NOT NULL,
  from_ms INTEGER NOT NULL,
  to_ms INTEGER NOT NULL,
  at_ms INTEGER NOT NULL
);
