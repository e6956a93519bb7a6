// Offsets, parameters and variables as the machine reports each change of them; the checks use the result.
// Store thread.
#pragma once

#include <cstdint>
#include <string>

#include "db/event_store.hpp"

namespace headstock::fleet {

struct OffsetChange {
  std::string what;              ///< "tool/3/geometry/X", "work/G54/Z", "parameter/3402#0", "variable/500"
  double before = 0, after = 0;  ///< mm; parameters and variables in their own unit
  std::string origin;            ///< program, panel, …
};

void record_offset(db::Database& db, const db::EventRow& event, const OffsetChange& change);
/// Writes the machine's offsets as the document that `headstock interpret --offsets` reads, under a new
/// version.
void rebuild_offsets(db::Database& db, std::int64_t machine, std::int64_t now_ms);

}  // namespace headstock::fleet
