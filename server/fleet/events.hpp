// Taking in what a machine's spool delivers: each event committed exactly once, with everything that is read
// from it, in one transaction. Store thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "db/event_store.hpp"

namespace headstock::fleet {

struct Intake {
  std::uint64_t sequence = 0;      ///< highest sequence below which nothing is missing: what is acknowledged
  std::vector<db::PartRow> parts;  ///< new ones, for those who watch
  std::vector<db::AlarmRow> raised, cleared;
  std::vector<db::RunRow> runs;
  bool states_changed = false, offsets_changed = false;
  std::vector<std::string> complaints;  ///< events that make no sense; kept raw, for the log
};

/// @param events array of {seq, at_ms, kind, …}: see fleet/README.md. Any order, repeats welcome.
Intake take_in(db::Database& db, std::int64_t machine, const std::string& spool, const nlohmann::json& events,
               std::int64_t now_ms);

}  // namespace headstock::fleet
