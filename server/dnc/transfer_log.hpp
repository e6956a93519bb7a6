// Every transfer of the shop, over ports and to agents, as one table for other programs: comma-separated
// values.
#pragma once

#include <cstdint>
#include <string>

#include "db/database.hpp"

namespace headstock::dnc {

struct LogWish {
  std::int64_t from_ms = 0, to_ms = 0;  ///< created in [from, to); 0: no limit
  std::int64_t port = 0, machine = 0;   ///< 0: all
};

/// The head line.
std::string log_head();
/// Rows newest first, at most `most`; `before_ms` and `before_id` lead on to the next piece: call again until
/// nothing is appended. A text that a spreadsheet would take for a formula gets an apostrophe in front. Store
/// thread.
struct LogPlace {
  std::int64_t port_before = 0, agent_before = 0;
  bool ports_done = false, agents_done = false;
};
bool append_log(db::Database& db, const LogWish& wish, LogPlace& place, std::string& out);

/// One value: quoted where needed.
std::string csv_value(const std::string& text);

}  // namespace headstock::dnc
