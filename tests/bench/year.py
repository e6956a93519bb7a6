#!/usr/bin/env python3
"""A year of a shop's history, made up, in a real server: how long its pages and figures take then.

    tests/bench/year.py [--machines 50] [--days 365] [--bin build/release/bin]

Prints one JSON line: rows, size of the database, and the median of five answers each (milliseconds) for the floor, the
OEE of a month and of one machine by shift, the stops of a week, and the alarm statistics of the year; beside them the same on
an empty shop, measured in the same run. Then the retention does its work on it (states older than 90 days by the hour, events
older than 180 days into files) while the floor is asked for: rows and used size after it (SQLite keeps the file's size and fills
it again), the files, how long it took, and that no hour has lost or won a second and no part is gone.
"""
import argparse
import json
import os
import random
import sqlite3
import statistics
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
DAY_MS = 86_400_000
SHA = "ab" * 32
# What one machine's year consists of; the other machines' years are made of it.
COPIED = {"state_intervals": ("machine_id", "state", "mode", "source", "from_ms", "to_ms"),
          "events": ("machine_id", "spool", "sequence", "at_ms", "received_ms", "kind", "body"),
          "parts": ("machine_id", "spool", "sequence", "at_ms", "program", "sha256", "machine_count", "machine_total", "cycle_s"),
          "runs": ("machine_id", "spool", "run", "program", "sha256", "started_ms", "ended_ms", "outcome", "run_s", "cutting_s"),
          "alarms": ("machine_id", "spool", "sequence", "alarm", "code", "text_en", "text_zh", "line", "column_number", "program", "block",
                     "raised_ms", "cleared_ms"),
          "downtime_notes": ("machine_id", "from_ms", "to_ms", "reason_id", "note", "by_user", "at_ms")}


def fill(file, machines, days):
    """States, parts, runs, alarms and notes of machines that work two shifts with stops every quarter of an hour."""
    random.seed(1)
    database = sqlite3.connect(file)
    database.executescript("PRAGMA synchronous = OFF; PRAGMA foreign_keys = OFF;")
    now = int(time.time() * 1000)
    database.execute("INSERT INTO blobs VALUES (?, 1, 1, 1, 'ascii', 'lf', 0, 1, 1)", (SHA,))
    for machine in range(1, machines + 1):
        database.execute("INSERT INTO checks (sha256, machine_id, config_hash, offsets_version, checker, ok, result_json, at_ms) "
                         "VALUES (?, ?, '', 0, '', 1, '{\"time_s\":600}', 1)", (SHA, machine))
        database.execute("INSERT INTO spools VALUES (?, 's', 0, 0)", (machine,))
        if machine > 1:   # the same year some minutes earlier
            for table, columns in COPIED.items():
                shifted = ", ".join(f"{name} - {machine} * 60000" if name.endswith("_ms") else str(machine) if name == "machine_id" else name for name in columns)
                database.execute(f"INSERT INTO {table} ({', '.join(columns)}) SELECT {shifted} FROM {table} WHERE machine_id = 1")
            database.commit()
            continue
        states, parts, events, runs, alarms, notes = [], [], [], [], [], []
        at, sequence = now - days * DAY_MS, 0
        while at < now:
            cut = random.randint(300_000, 1_200_000)
            stand = random.randint(20_000, 300_000)
            state = random.choice(["idle", "idle", "hold", "alarm", "setup"])
            states.append((machine, "running", "memory", "machine", at, at + cut))
            sequence += 4
            body = json.dumps({"run": sequence, "program": "O1001", "sha256": SHA, "count": sequence // 4, "total": sequence // 4, "cycle_s": cut / 1000})
            for back, kind, when in ((3, "run_started", at), (2, "state", at), (1, "state", at + cut), (0, "part", at + cut)):
                events.append((machine, "s", sequence - back, when, when, kind, body))
            parts.append((machine, "s", sequence, at + cut, "O1001", SHA, sequence, sequence, cut / 1000))
            runs.append((machine, "s", sequence, "O1001", SHA, at, at + cut, "completed", cut / 1000, cut / 1200))
            if state == "alarm":
                alarms.append((machine, "s", sequence, sequence, f"PS{random.randint(1, 60):04d}", "ALARM", "报警", 1, 1, "O1001",
                               "G01 X10.", at + cut, at + cut + stand))
            elif stand > 240_000:
                notes.append((machine, at + cut, at + cut + stand, random.randint(1, 9), "", "li", at + cut + stand))
            states.append((machine, state, "memory", "machine", at + cut, at + cut + stand))
            at += cut + stand
        states[-1] = states[-1][:5] + (None,)
        many = database.executemany
        many("INSERT INTO state_intervals (machine_id, state, mode, source, from_ms, to_ms) VALUES (?, ?, ?, ?, ?, ?)", states)
        many("INSERT INTO events VALUES (?, ?, ?, ?, ?, ?, ?)", events)
        many("INSERT INTO parts (machine_id, spool, sequence, at_ms, program, sha256, machine_count, machine_total, cycle_s) "
             "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", parts)
        many("INSERT INTO runs (machine_id, spool, run, program, sha256, started_ms, ended_ms, outcome, run_s, cutting_s) "
             "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", runs)
        many("INSERT INTO alarms (machine_id, spool, sequence, alarm, code, text_en, text_zh, line, column_number, program, block, "
             "raised_ms, cleared_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)", alarms)
        many("INSERT INTO downtime_notes (machine_id, from_ms, to_ms, reason_id, note, by_user, at_ms) VALUES (?, ?, ?, ?, ?, ?, ?)", notes)
        database.commit()
    rows = {table: database.execute(f"SELECT COUNT(*) FROM {table}").fetchone()[0]
            for table in ("state_intervals", "events", "parts", "runs", "alarms", "downtime_notes")}
    database.close()
    return rows


def used_mib(database):
    page, pages, free = (database.execute(f"PRAGMA {name}").fetchone()[0] for name in ("page_size", "page_count", "freelist_count"))
    return round((pages - free) * page / (1 << 20), 1)


KEPT = {"states_days": 90, "events_days": 180, "transfers_days": 180, "backup_every_hours": 0, "backups_kept": 7}


def look(file):
    """What the retention may change and what it must not; the server must be stopped: it keeps its database to itself."""
    database = sqlite3.connect(file)
    one = lambda sql, *values: database.execute(sql, values).fetchone()[0]
    old = int(time.time() * 1000) - KEPT["events_days"] * DAY_MS
    found = {"used_mib": used_mib(database), "state_intervals": one("SELECT COUNT(*) FROM state_intervals"), "events": one("SELECT COUNT(*) FROM events"),
             "old_events": one("SELECT COUNT(*) FROM events WHERE received_ms < ? AND kind = 'state'", old), "parts": one("SELECT COUNT(*) FROM parts"),
             "part_events": one("SELECT COUNT(*) FROM events WHERE kind IN ('part', 'run_started', 'run_ended')"),
             "sums": dict(((machine, state), total) for machine, state, total in database.execute(
                 "SELECT machine_id, state, SUM(to_ms - from_ms) FROM state_intervals WHERE to_ms IS NOT NULL GROUP BY 1, 2"))}
    database.close()
    return found


def retention(shop, file):
    """Lets the server keep states for 90 days and events for 180, and looks at what is left."""
    shop.server.stop()
    before = look(file)
    shop.start_server()
    shop.admin.call("PATCH", "/settings/keeping", KEPT)
    began, slowest, archived = time.monotonic(), 0.0, 0
    while archived < before["old_events"]:   # states are gathered before events are put away
        asked = time.perf_counter()
        shop.admin.get("/machines")
        slowest = max(slowest, time.perf_counter() - asked)
        time.sleep(0.2)
        archives = shop.admin.get("/event-archives")["items"]
        archived = sum(one["events"] for one in archives)
    took = time.monotonic() - began
    median = answers(shop)
    shop.server.stop()
    after = look(file)
    lost = {key: (after["sums"].get(key, 0), total) for key, total in before["sums"].items() if after["sums"].get(key, 0) != total}
    # Only the interval that was open when the server stopped and came back may have got an end.
    assert all(now > then for now, then in lost.values()) and len(lost) <= len({machine for machine, _ in before["sums"]}), lost
    assert (after["parts"], after["part_events"]) == (before["parts"], before["part_events"]), "parts and runs stay"
    shown = ("used_mib", "state_intervals", "events")
    files = os.path.join(os.path.dirname(file), "archive")
    return {"before": {key: before[key] for key in shown}, "after": {key: after[key] for key in shown}, "events_in_files": archived,
            "files_mib": round(sum(os.path.getsize(os.path.join(files, one["file"])) for one in archives) / (1 << 20), 1),
            "took_s": round(took, 1), "floor_slowest_ms": round(1000 * slowest, 1), "median_ms": median}


def answers(shop):
    """Median milliseconds of five answers each."""
    now = time.time()
    utc = lambda days: time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(now - days * 86_400))
    questions = {
        "floor": ("/machines", {}), "oee_month_all": ("/oee", {"from": utc(30), "to": utc(0)}),
        "oee_month_by_shift_one": ("/oee", {"from": utc(30), "to": utc(0), "by": "shift", "machine": 1}),
        "oee_year_one_by_week": ("/oee", {"from": utc(365), "to": utc(0), "by": "week", "machine": 1}),
        "stops_week": ("/machines/1/stops", {"from": utc(7), "to": utc(0)}),
        "alarms_page": ("/alarms", {"limit": 200}), "alarm_statistics_year": ("/alarms/statistics", {"from": utc(365), "to": utc(0)}),
    }
    found = {}
    for name, (path, query) in questions.items():
        took = []
        for _ in range(5):
            began = time.perf_counter()
            shop.admin.call("GET", path, query=query)
            took.append(1000 * (time.perf_counter() - began))
        found[name] = round(statistics.median(took), 1)
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--machines", type=int, default=50)
    parser.add_argument("--days", type=int, default=365)
    parser.add_argument("--bin", default=os.path.join(HERE, "../../build/release/bin"))
    options = parser.parse_args()
    os.environ["HEADSTOCK_BIN"] = os.path.abspath(options.bin)
    sys.path.insert(0, os.path.join(HERE, "../integration"))
    from shop import Shop

    shop = Shop()
    try:
        shop.start_server()
        for number in range(options.machines):
            shop.admin.post("/machines", {"name": f"Machine {number + 1:03d}", "profile": "fanuc-0i-t"})
        shop.admin.call("PATCH", "/calendar", {"time_zone": "Europe/Berlin", "shifts": [
            {"name": "Early", "days": [1, 2, 3, 4, 5], "start": "06:00", "end": "14:00"},
            {"name": "Late", "days": [1, 2, 3, 4, 5], "start": "14:00", "end": "22:00"}]})
        empty = answers(shop)
        shop.server.stop()
        file = os.path.join(shop.folder, "server", "headstock.db")
        rows = fill(file, options.machines, options.days)
        shop.start_server()
        result = {"machines": options.machines, "days": options.days, "rows": rows,
                  "database_mib": round(os.path.getsize(file) / (1 << 20), 1), "median_ms": answers(shop), "empty_shop_ms": empty}
        result["retention"] = retention(shop, file)
        print(json.dumps(result))
    finally:
        shop.close()


if __name__ == "__main__":
    main()
