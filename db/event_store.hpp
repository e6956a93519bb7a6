// What machines reported: raw events once each, and the parts, runs, alarms and states read from them. Store
// thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "db/page.hpp"

namespace headstock::db {

struct EventRow {
  std::int64_t machine = 0;
  std::string spool;
  std::int64_t sequence = 0, at_ms = 0, received_ms = 0;
  std::string kind, body;  ///< body: the event as JSON
};
/// @return false when this sequence of this spool is there already: a repeat, to be ignored.
bool insert_event(Database& db, const EventRow& event);
/// Highest sequence below which nothing is missing; 0 for an unknown spool, which is remembered.
std::int64_t spool_sequence(Database& db, std::int64_t machine, const std::string& spool, std::int64_t at_ms);
/// Moves it up over what has arrived. @return the new value.
std::int64_t advance_spool(Database& db, std::int64_t machine, const std::string& spool);
/// The agent no longer has what lies below `sequence` (this database is older than its acknowledgements):
/// notes the gap.
void skip_spool_to(Database& db, std::int64_t machine, const std::string& spool, std::int64_t sequence,
                   std::int64_t at_ms);

struct PartRow {
  std::int64_t id = 0, machine = 0;
  std::string spool;
  std::int64_t sequence = 0, at_ms = 0;
  std::string program, sha256;
  std::int64_t machine_count = 0, machine_total = 0;  ///< as the machine's own counter said
  double cycle_s = 0;
};
struct RunRow {
  std::int64_t id = 0, machine = 0;
  std::string spool;
  std::int64_t run = 0;
  std::string program, sha256;
  std::optional<std::int64_t> started_ms, ended_ms;
  std::string outcome;  ///< completed reset alarm interrupted; empty while running or not known
  std::optional<double> run_s, cutting_s;
  std::optional<std::int64_t> total_start, total_end;  ///< the machine's part counter: the second witness
  std::optional<std::int64_t> holds, alarms;
  std::string overrides_json;  ///< {"feed":[least,most],…} in percent; empty: not told
  std::string by;              ///< who pressed cycle start; empty: at the machine
};
struct AlarmRow {
  std::int64_t id = 0, machine = 0;
  std::string spool;
  std::int64_t sequence = 0;  ///< of the event that raised it
  std::int64_t alarm = 0;     ///< the controller's own counter
  std::string code, text_en, text_zh;
  std::int64_t line = 0, column = 0;
  std::string program, block;
  std::int64_t raised_ms = 0;
  std::optional<std::int64_t> cleared_ms;
};
struct StateRow {
  std::int64_t id = 0, machine = 0;
  std::string state, mode;
  std::string source;  ///< machine: it said so · server: concluded from its silence
  std::int64_t from_ms = 0;
  std::optional<std::int64_t> to_ms;
};

/// Of every history list. Times: [from, to).
struct HistoryFilter {
  std::int64_t machine = 0;  ///< 0: all
  std::optional<std::int64_t> from_ms, to_ms;
};
struct AlarmFilter : HistoryFilter {
  std::string code;  ///< exactly; empty: all
  std::string text;  ///< part of code, either text, program or block
  bool active_only = false;
};
Listed<PartRow> parts(Database& db, const HistoryFilter& filter, const Page& page);
std::int64_t part_total(Database& db, const HistoryFilter& filter);
Listed<RunRow> runs(Database& db, const HistoryFilter& filter, const Page& page);
Listed<AlarmRow> alarms(Database& db, const AlarmFilter& filter, const Page& page);
/// Oldest first, whole intervals that touch the time; at most 10,000.
std::vector<StateRow> states(Database& db, const HistoryFilter& filter);
/// The same of one machine, however many. `row` must not use the database.
void each_state(Database& db, const HistoryFilter& filter, const std::function<void(const StateRow&)>& row);

std::int64_t insert_part(Database& db, const PartRow& part);
/// Start and end may come in either order and from different batches.
void put_run_start(Database& db, const RunRow& run);
void put_run_end(Database& db, const RunRow& run);
std::int64_t insert_alarm(Database& db, const AlarmRow& alarm);
/// Ends the active alarm with the controller's number. @return it, nothing when it is not known or not
/// active.
std::optional<AlarmRow> clear_alarm(Database& db, std::int64_t machine, const std::string& spool,
                                    std::int64_t alarm, std::int64_t at_ms);
/// Ends all that are active: the controller was restarted. @return them.
std::vector<AlarmRow> clear_all_alarms(Database& db, std::int64_t machine, std::int64_t at_ms);

}  // namespace headstock::db
