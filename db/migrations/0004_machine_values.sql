-- What machines keep in their pages: offsets, tool life, parameters, variables. `machine_values` is what each has now,
-- `value_changes` how it came to that, `value_requests` what people asked to be written.
CREATE TABLE machine_values (
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  what TEXT NOT NULL,
  value REAL,
  spool TEXT NOT NULL DEFAULT '',
  sequence INTEGER NOT NULL DEFAULT 0,
  at_ms INTEGER NOT NULL,
  PRIMARY KEY (machine_id, what)
);
INSERT INTO machine_values (machine_id, what, value, at_ms) SELECT machine_id, what, value, at_ms FROM offsets;
DROP TABLE offsets;
CREATE TABLE value_changes (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  spool TEXT NOT NULL,
  sequence INTEGER,
  at_ms INTEGER NOT NULL,
  received_ms INTEGER NOT NULL,
  what TEXT NOT NULL,
  before_value REAL,
  after_value REAL,
  origin TEXT NOT NULL,
  by_user TEXT NOT NULL DEFAULT '',
  request_id INTEGER NOT NULL DEFAULT 0,
  UNIQUE (machine_id, spool, sequence)
);
INSERT INTO value_changes (machine_id, spool, sequence, at_ms, received_ms, what, before_value, after_value, origin)
  SELECT machine_id, spool, sequence, at_ms, at_ms, what, before_value, after_value, origin FROM offset_changes ORDER BY id;
DROP TABLE offset_changes;
CREATE INDEX value_changes_what ON value_changes (machine_id, what, id);
CREATE INDEX value_changes_request ON value_changes (request_id);
CREATE TABLE value_requests (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  by_user TEXT NOT NULL,
  at_ms INTEGER NOT NULL,
  origin TEXT NOT NULL,
  why TEXT NOT NULL DEFAULT '',
  state TEXT NOT NULL CHECK (state IN ('waiting', 'sending', 'unknown', 'done', 'refused', 'failed', 'withdrawn')),
  needs_second TEXT NOT NULL DEFAULT '',
  second_user TEXT NOT NULL DEFAULT '',
  second_ms INTEGER,
  reason TEXT NOT NULL DEFAULT '',
  where_value TEXT NOT NULL DEFAULT '',
  ended_ms INTEGER
);
CREATE INDEX value_requests_open ON value_requests (machine_id) WHERE ended_ms IS NULL;
CREATE TABLE value_request_items (
  request_id INTEGER NOT NULL REFERENCES value_requests (id),
  position INTEGER NOT NULL,
  what TEXT NOT NULL,
  before_value REAL,
  after_value REAL,
  read_back REAL,
  was_read INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (request_id, position)
);
-- machine_id 0: the shop's own. Largest single change that one person may make; none: no row.
CREATE TABLE value_limits (
  machine_id INTEGER NOT NULL,
  kind TEXT NOT NULL CHECK (kind IN ('wear', 'geometry', 'radius', 'work', 'variable', 'parameter', 'tool_life')),
  step REAL NOT NULL,
  PRIMARY KEY (machine_id, kind)
);
INSERT INTO value_limits (machine_id, kind, step) VALUES (0, 'wear', 0.2);
CREATE TABLE value_snapshots (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  profile TEXT NOT NULL,
  name TEXT NOT NULL,
  by_user TEXT NOT NULL,
  at_ms INTEGER NOT NULL
);
CREATE TABLE value_snapshot_rows (
  snapshot_id INTEGER NOT NULL REFERENCES value_snapshots (id),
  what TEXT NOT NULL,
  value REAL NOT NULL,
  PRIMARY KEY (snapshot_id, what)
);

-- Runs say more; parts belong to orders; witnesses that disagree are kept.
ALTER TABLE runs ADD COLUMN total_start INTEGER;
ALTER TABLE runs ADD COLUMN total_end INTEGER;
ALTER TABLE runs ADD COLUMN holds INTEGER;
ALTER TABLE runs ADD COLUMN alarms INTEGER;
ALTER TABLE runs ADD COLUMN overrides_json TEXT NOT NULL DEFAULT '';
ALTER TABLE runs ADD COLUMN by_user TEXT NOT NULL DEFAULT '';
CREATE TABLE count_disagreements (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  spool TEXT NOT NULL,
  sequence INTEGER NOT NULL,
  at_ms INTEGER NOT NULL,
  kind TEXT NOT NULL CHECK (kind IN ('counter_step', 'run_parts')),
  counted INTEGER NOT NULL,
  witness INTEGER NOT NULL,
  run INTEGER NOT NULL DEFAULT 0,
  seen_by TEXT NOT NULL DEFAULT '',
  seen_ms INTEGER,
  UNIQUE (machine_id, spool, sequence, kind)
);
CREATE TABLE orders (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  machine_id INTEGER REFERENCES machines (id),
  program TEXT NOT NULL DEFAULT '',
  required INTEGER NOT NULL,
  from_ms INTEGER NOT NULL,
  by_user TEXT NOT NULL,
  closed_ms INTEGER,
  closed_by TEXT NOT NULL DEFAULT ''
);

CREATE TRIGGER value_changes_kept_update BEFORE UPDATE ON value_changes BEGIN SELECT RAISE(ABORT, 'value changes are immutable'); END;
CREATE TRIGGER value_changes_kept_delete BEFORE DELETE ON value_changes BEGIN SELECT RAISE(ABORT, 'value changes are immutable'); END;
CREATE TRIGGER value_snapshot_rows_kept_update BEFORE UPDATE ON value_snapshot_rows BEGIN SELECT RAISE(ABORT, 'snapshots are immutable'); END;
CREATE TRIGGER value_snapshot_rows_kept_delete BEFORE DELETE ON value_snapshot_rows BEGIN SELECT RAISE(ABORT, 'snapshots are immutable'); END;
