// Machines as people manage them: create, change, remove, one-time tokens. Store thread; each function is one
// transaction with its audit row.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "db/machine_store.hpp"
#include "server/access/role.hpp"

namespace headstock::fleet {

inline constexpr std::int64_t kTokenLifeMs = 3'600'000;  ///< protocol/wire/README.md: valid one hour

/// Refusals: forbidden, bad_name, name_taken, bad_profile, bad_machine_file (where: the line and what is
/// wrong).
db::MachineRow create_machine(db::Database& db, const access::Actor& actor, const std::string& name,
                              const std::string& profile, const std::string& toml, std::int64_t now_ms);
struct MachineChange {
  std::optional<std::string> name, toml;
  std::optional<std::int64_t> parts_required;
};
db::MachineRow change_machine(db::Database& db, const access::Actor& actor, std::int64_t id,
                              const MachineChange& change, std::int64_t now_ms);
void remove_machine(db::Database& db, const access::Actor& actor, std::int64_t id, std::int64_t now_ms);
/// @return the secret part of `HS1-<secret>-<CA fingerprint>`; only its hash is kept. Earlier unused tokens
/// end.
std::string issue_token(db::Database& db, const access::Actor& actor, std::int64_t machine,
                        std::int64_t now_ms);
/// What a check of a program depends on besides the offsets.
std::string config_hash(const std::string& profile, const std::string& toml);
/// Refusals: not_found.
db::MachineRow require_machine(db::Database& db, std::int64_t id);

}  // namespace headstock::fleet
