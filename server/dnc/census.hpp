// What lies in every machine, and how that is known: an agent reports it, a port knows what it sent whole and
// what was punched back. Nothing is taken for current only because it was sent once: each entry says since
// when and by what.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "db/database.hpp"

namespace headstock::dnc {

struct CensusEntry {
  std::int64_t machine = 0, port = 0;  ///< 0: a port without a machine; 0: an agent
  std::string machine_name, port_name;
  std::string name, sha256;
  std::int64_t program = 0, revision = 0;  ///< 0: this content is not in the library
  std::int64_t released = 0;               ///< revision released now; 0: none
  /// reported (by the agent), sent (whole, drained, the control said nothing since), punched (by the control)
  std::string proof;
  /// released (this is the released revision), older (a revision that is not the released one), changed
  /// (punched back different from the library), unknown (not in the library)
  std::string state;
  std::string classes;         ///< of changed: what differs
  std::int64_t since_ms = 0;   ///< 0: not known
  std::int64_t proven_ms = 0;  ///< when it was last seen to be so
};

/// Store thread. @param machine 0: all. Sorted by machine and name.
std::vector<CensusEntry> census(db::Database& db, std::int64_t machine);

}  // namespace headstock::dnc
