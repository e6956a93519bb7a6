// Machine data that a control has punched and somebody has accepted, on their way into the machine's pages.
// Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "db/value_store.hpp"
#include "server/access/role.hpp"

namespace headstock::fleet {

struct PunchedSet {
  std::int64_t machine = 0;
  std::int64_t punch = 0;  ///< number of the record: a later punch is never undone by an earlier one
  std::int64_t at_ms = 0;  ///< when it was punched
  db::MachineValues values;
  std::string why;
  /// Write what differs into a machine that has an agent: its values would otherwise stay as they are, a
  /// punch may be older than what the machine has.
  bool write = false;
};

struct PunchedOutcome {
  std::int64_t written = 0;  ///< values of a machine without an agent that are now known so
  std::int64_t differ = 0;   ///< values that its agent has otherwise
  std::int64_t same = 0;
  std::int64_t without_place = 0;              ///< the machine has no such value; the set keeps it
  std::optional<db::ValueRequestRow> request;  ///< waiting for a second person, or to be sent (ValueDesk)
};

/// A machine without an agent tells what it has by its punches: its values are written down as changes of
/// origin "import" by the person who accepted. A machine with an agent is the truth of what it has: what
/// differs is counted and, when asked for, becomes a request of origin "import" with its limits and its
/// second person (value_requests.hpp). Inside the transaction of the acceptance. Refusals: forbidden
/// (edit_offsets), not_found, those of ask_values.
PunchedOutcome take_punched(db::Database& db, const access::Actor& actor, const PunchedSet& set,
                            std::int64_t now_ms);

}  // namespace headstock::fleet
