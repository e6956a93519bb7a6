// Sending at a time (plans), and machine data that came over a port and that somebody has accepted. Plain
// rows; the rules are in server/dnc. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "db/page.hpp"

namespace headstock::db {

struct PlanRow {
  std::int64_t id = 0, port = 0, program = 0, revision = 0;
  std::string name;
  bool drip = false;
  std::int64_t from_line = 1;
  std::string header;
  std::int64_t at_ms = 0;
  std::string state = "planned";  ///< planned, started, missed, refused, cancelled
  std::string reason;             ///< message key of missed and refused
  std::int64_t transfer = 0;      ///< of started
  std::string by;
  std::int64_t by_id = 0, created_ms = 0;
  std::optional<std::int64_t> ended_ms;
};
std::int64_t insert_plan(Database& db, const PlanRow& row);
/// Writes state, reason, transfer and ended.
void update_plan(Database& db, const PlanRow& row);
std::optional<PlanRow> plan(Database& db, std::int64_t id);
/// Newest first. @param port 0: all.
Listed<PlanRow> plans(Database& db, std::int64_t port, bool open_only, const Page& page);
/// Planned ones whose time is not after `until_ms`, earliest first.
std::vector<PlanRow> due_plans(Database& db, std::int64_t until_ms);

/// A set of machine data as a control punched it: its text is a blob, immutable.
struct PunchedDataRow {
  std::int64_t id = 0, received = 0, port = 0, machine = 0;
  std::string kind, name, sha256;
  std::int64_t entries = 0;
  std::string by;
  std::int64_t punched_ms = 0, accepted_ms = 0;
};
std::int64_t insert_punched_data(Database& db, const PunchedDataRow& row);
std::optional<PunchedDataRow> punched_data(Database& db, std::int64_t id);
/// The set of the same port and kind before this one.
std::optional<PunchedDataRow> punched_data_before(Database& db, const PunchedDataRow& row);
/// Newest first. @param machine 0: all. @param kind empty: all.
Listed<PunchedDataRow> punched_data_rows(Database& db, std::int64_t machine, const std::string& kind,
                                         const Page& page);

}  // namespace headstock::db
