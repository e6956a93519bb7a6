// Part counts by two witnesses, and the count made again from the raw events. Store thread.
//
// The first witness is the part itself: one event for each M02, M30 or counting M code, with the number the
// machine gave it. The second is the machine's total counter: it must grow by one from part to part, and by
// as many between the start and the end of a run as parts were told in it. Where they disagree nobody
// guesses: it is an alarm (HS-COUNT) until a person has looked, and a row that stays.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/event_store.hpp"
#include "db/page.hpp"
#include "server/access/role.hpp"

namespace headstock::fleet {

inline constexpr const char* kCountAlarm = "HS-COUNT";

/// Looks at what came in between two acknowledgements, when nothing is missing below the newer one.
/// @param raised the alarms made of it
void hold_against_each_other(db::Database& db, std::int64_t machine, const std::string& spool,
                             std::int64_t after, std::int64_t up_to, std::vector<db::AlarmRow>& raised);

struct Disagreement {
  std::int64_t id = 0, machine = 0, sequence = 0, at_ms = 0;
  std::string spool,
      kind;  ///< counter_step: the counter did not grow by one · run_parts: as many as the counter grew
  std::int64_t counted = 0, witness = 0, run = 0;
  std::string seen_by;
  std::optional<std::int64_t> seen_ms;
};
db::Listed<Disagreement> disagreements(db::Database& db, std::int64_t machine, const db::Page& page);
/// A person has looked: the alarm ends. Refusals: forbidden, not_found.
void acknowledge(db::Database& db, const access::Actor& actor, std::int64_t disagreement,
                 std::int64_t now_ms);

/// A machine's totals read again from its raw events and held against the tables.
struct Recount {
  std::int64_t machine = 0;
  std::string name;
  std::int64_t events = 0, parts = 0, parts_stored = 0, runs = 0, runs_stored = 0, runs_open = 0;
  std::int64_t missing = 0;              ///< events that never came (gaps of the spool)
  std::vector<std::string> differences;  ///< at most 100; empty: identical
};
/// @param machine 0: all
std::vector<Recount> recount(db::Database& db, std::int64_t machine);

}  // namespace headstock::fleet
