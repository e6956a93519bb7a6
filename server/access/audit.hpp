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

}  // namespace headstock::access
