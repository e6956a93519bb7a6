-- Time and quality: shifts, why machines stood, rejected parts. Rows say who and when; a correction is a newer row.

CREATE TABLE shifts (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL,
  days INTEGER NOT NULL CHECK (days BETWEEN 1 AND 127),
  start_minute INTEGER NOT NULL CHECK (start_minute BETWEEN 0 AND 1439),
  end_minute INTEGER NOT NULL CHECK (end_minute BETWEEN 0 AND 1439)
);
CREATE TABLE downtime_reasons (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name_en TEXT NOT NULL,
  name_zh TEXT NOT NULL,
  planned INTEGER NOT NULL DEFAULT 0,
  position INTEGER NOT NULL DEFAULT 0,
  removed_ms INTEGER
);
INSERT INTO downtime_reasons (name_en, name_zh, planned, position) VALUES
  ('Setting up', '调机换型', 0, 1),
  ('Tool change', '换刀', 0, 2),
  ('Waiting for material', '待料', 0, 3),
  ('Waiting for inspection', '待检', 0, 4),
  ('No operator', '缺人', 0, 5),
  ('Machine fault', '设备故障', 0, 6),
  ('Maintenance', '计划保养', 1, 7),
  ('Break', '休息', 1, 8),
  ('No order', '无订单', 1, 9);
CREATE TABLE downtime_notes (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  from_ms INTEGER NOT NULL,
  to_ms INTEGER NOT NULL CHECK (to_ms > from_ms),
  reason_id INTEGER REFERENCES downtime_reasons (id),
  note TEXT NOT NULL,
  by_user TEXT NOT NULL,
  at_ms INTEGER NOT NULL
);
CREATE INDEX downtime_notes_from ON downtime_notes (machine_id, from_ms);
CREATE TABLE rejects (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  machine_id INTEGER NOT NULL REFERENCES machines (id),
  at_ms INTEGER NOT NULL,
  program TEXT NOT NULL,
  quantity INTEGER NOT NULL,
  why TEXT NOT NULL,
  by_user TEXT NOT NULL,
  entered_ms INTEGER NOT NULL
);
CREATE INDEX rejects_at ON rejects (machine_id, at_ms);
CREATE INDEX checks_of_machine ON checks (machine_id, sha256);

CREATE TRIGGER downtime_notes_kept_update BEFORE UPDATE ON downtime_notes BEGIN SELECT RAISE(ABORT, 'downtime notes are immutable'); END;
CREATE TRIGGER downtime_notes_kept_delete BEFORE DELETE ON downtime_notes BEGIN SELECT RAISE(ABORT, 'downtime notes are immutable'); END;
CREATE TRIGGER rejects_kept_update BEFORE UPDATE ON rejects BEGIN SELECT RAISE(ABORT, 'rejected parts are immutable'); END;
CREATE TRIGGER rejects_kept_delete BEFORE DELETE ON rejects BEGIN SELECT RAISE(ABORT, 'rejected parts are immutable'); END;
