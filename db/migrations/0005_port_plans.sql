-- What a transfer's certificate needs to be read again later; sending at a time; machine data that somebody has accepted; what a
-- port knows about its own line.
ALTER TABLE port_transfers ADD COLUMN settings_json TEXT NOT NULL DEFAULT '{}';
CREATE TABLE port_plans (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  port_id INTEGER NOT NULL REFERENCES ports (id),
  program_id INTEGER NOT NULL,
  revision INTEGER NOT NULL,
  name TEXT NOT NULL,
  drip INTEGER NOT NULL DEFAULT 0,
  from_line INTEGER NOT NULL DEFAULT 1,
  header TEXT NOT NULL DEFAULT '',
  at_ms INTEGER NOT NULL,
  state TEXT NOT NULL DEFAULT 'planned' CHECK (state IN ('planned', 'started', 'missed', 'refused', 'cancelled')),
  reason TEXT NOT NULL DEFAULT '',
  transfer_id INTEGER,
  by_user TEXT NOT NULL,
  by_user_id INTEGER NOT NULL,
  created_ms INTEGER NOT NULL,
  ended_ms INTEGER
);
CREATE INDEX port_plans_open ON port_plans (at_ms) WHERE ended_ms IS NULL;
CREATE TABLE punched_data (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  received_id INTEGER NOT NULL REFERENCES received (id),
  port_id INTEGER NOT NULL REFERENCES ports (id),
  machine_id INTEGER REFERENCES machines (id),
  kind TEXT NOT NULL,
  name TEXT NOT NULL,
  sha256 TEXT NOT NULL REFERENCES blobs (sha256),
  entries INTEGER NOT NULL,
  by_user TEXT NOT NULL,
  punched_ms INTEGER NOT NULL,
  accepted_ms INTEGER NOT NULL
);
CREATE INDEX punched_data_machine ON punched_data (machine_id, kind, id);
CREATE TABLE port_measures (
  port_id INTEGER PRIMARY KEY REFERENCES ports (id),
  transfers INTEGER NOT NULL DEFAULT 0,
  stops INTEGER NOT NULL DEFAULT 0,
  most_after_stop INTEGER NOT NULL DEFAULT 0,
  longest_stop_us INTEGER NOT NULL DEFAULT 0,
  longest_hold_ms INTEGER NOT NULL DEFAULT 0,
  starved_ms INTEGER NOT NULL DEFAULT 0,
  sending_ms INTEGER NOT NULL DEFAULT 0,
  round_trip_us INTEGER NOT NULL DEFAULT 0,
  at_ms INTEGER NOT NULL DEFAULT 0
);
