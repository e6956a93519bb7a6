// The records of ports: who may change them and what they may say. Store thread, each in its own transaction
// with its audit row.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "db/port_store.hpp"
#include "server/access/role.hpp"

namespace headstock::dnc {

/// @param fields {name, machine, address, settings, listens, folder, name_rule, rules}; address and name are
/// needed. Refusals: forbidden, bad_name, name_taken, bad_value (where: the field), bad_folder, not_found
/// (machine).
db::PortRow create_port(db::Database& db, const access::Actor& actor, const nlohmann::json& fields,
                        std::int64_t now_ms);
/// What is not named stays. Refusals: as create_port, not_found.
db::PortRow change_port(db::Database& db, const access::Actor& actor, std::int64_t id,
                        const nlohmann::json& fields, std::int64_t now_ms);
void remove_port(db::Database& db, const access::Actor& actor, std::int64_t id, std::int64_t now_ms);
db::PortRow require_port(db::Database& db, std::int64_t id);

}  // namespace headstock::dnc
