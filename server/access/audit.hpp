// The audit trail: who changed what, from where, in the same transaction as the change.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "db/user_store.hpp"
#include "server/access/role.hpp"

namespace headstock::access {

/// How an audit row names what was changed: "program:7".
std::string subject(std::string_view kind, std::int64_t id);

/// Call inside the transaction of the change. `detail` becomes a JSON object of texts.
/// @param action e.g. "program.release"; @param subject see subject()
void record(db::Database& db, const Actor& actor, std::string_view action, const std::string& subject,
            std::initializer_list<std::pair<std::string_view, std::string>> detail = {});

struct AuditVerdict {
  std::int64_t broken = 0;  ///< id of the first row that is not as it was written; 0: all are
  std::string what;         ///< changed, missing, cut; empty when whole
  db::AuditHead head;       ///< newest row: keep it somewhere else and give it as `seen` the next time
};
/// Walks the whole chain. @param seen what an earlier verdict said; id 0: nothing. Finds rows that were changed,
/// removed, slipped in or reordered, and, with `seen`, an end that was cut off or written anew. Store thread.
AuditVerdict verify_audit(db::Database& db, const db::AuditHead& seen);

}  // namespace headstock::access
