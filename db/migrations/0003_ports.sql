-- Machines whose own control speaks over a serial line: their ports, what went over them, what came back.
CREATE TABLE ports (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  machine_id INTEGER REFERENCES machines (id),
  address TEXT NOT NULL,
  settings_json TEXT NOT NULL,
  listens INTEGER NOT NULL DEFAULT 0,
  folder TEXT NOT NULL DEFAULT '/',
  name_rule TEXT NOT NULL DEFAULT 'number' CHECK (name_rule IN ('number', 'comment')),
  rules_json TEXT NOT NULL DEFAULT '[]',
  created_ms INTEGER NOT NULL,
  changed_ms INTEGER NOT NULL,
  removed_ms INTEGER
);
CREATE UNIQUE INDEX ports_name ON ports (name) WHERE removed_ms IS NULL;
CREATE TABLE port_transfers (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  port_id INTEGER NOT NULL REFERENCES ports (id),
  kind TEXT NOT NULL CHECK (kind IN ('send', 'drip', 'receive', 'answer')),
  state TEXT NOT NULL CHECK (state IN ('queued', 'waiting', 'sending', 'held', 'paused', 'draining', 'receiving', 'done', 'failed', 'cancelled')),
  program_id INTEGER,
  revision INTEGER,
  name TEXT NOT NULL DEFAULT '',
  sha256 TEXT NOT NULL DEFAULT '',
  from_line INTEGER NOT NULL DEFAULT 1,
  header TEXT NOT NULL DEFAULT '',
  bytes INTEGER NOT NULL DEFAULT 0,
  total INTEGER NOT NULL DEFAULT 0,
  wire_sha256 TEXT NOT NULL DEFAULT '',
  reason TEXT NOT NULL DEFAULT '',
  detail TEXT NOT NULL DEFAULT '',
  figures_json TEXT NOT NULL DEFAULT '{}',
  by_user TEXT NOT NULL,
  created_ms INTEGER NOT NULL,
  started_ms INTEGER,
  ended_ms INTEGER
);
CREATE INDEX port_transfers_port ON port_transfers (port_id, id);
CREATE INDEX port_transfers_open ON port_transfers (port_id) WHERE ended_ms IS NULL;
-- What a control punched, before a person has looked at it. Its text is a blob; the library is untouched.
CREATE TABLE received (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  port_id INTEGER NOT NULL REFERENCES ports (id),
  transfer_id INTEGER NOT NULL REFERENCES port_transfers (id),
  machine_id INTEGER,
  kind TEXT NOT NULL,
  name TEXT NOT NULL,
  comment TEXT NOT NULL DEFAULT '',
  sha256 TEXT NOT NULL REFERENCES blobs (sha256),
  closed INTEGER NOT NULL,
  folder TEXT NOT NULL,
  program_id INTEGER,
  against_revision INTEGER,
  classes TEXT NOT NULL DEFAULT '',
  state TEXT NOT NULL DEFAULT 'waiting' CHECK (state IN ('waiting', 'same', 'accepted', 'rejected')),
  decided_by TEXT NOT NULL DEFAULT '',
  decided_why TEXT NOT NULL DEFAULT '',
  decided_ms INTEGER,
  at_ms INTEGER NOT NULL
);
CREATE INDEX received_waiting ON received (state, id);
CREATE TRIGGER ended_port_transfers_kept BEFORE UPDATE ON port_transfers WHEN OLD.ended_ms IS NOT NULL
BEGIN SELECT RAISE(ABORT, 'ended transfers are immutable'); END;
CREATE TRIGGER port_transfers_kept_delete BEFORE DELETE ON port_transfers
BEGIN SELECT RAISE(ABORT, 'transfers are immutable'); END;
