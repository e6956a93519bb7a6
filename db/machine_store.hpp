// Machines, their certificates and one-time tokens, what is resident in them, their offsets. Plain rows; the
// rules are in server/fleet. Store thread only.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"

namespace headstock::db {

struct MachineRow {
  std::int64_t id = 0;
  std::string name, profile;
  std::string toml;          ///< the machine file; empty: the profile's default machine
  std::string config_hash;   ///< SHA-256 of profile and toml: what a check result depends on
  std::string offsets_json;  ///< as `headstock interpret --offsets` reads it; "{}" when never reported
  std::int64_t offsets_version = 0;
  std::optional<std::int64_t> offsets_at_ms;
  std::int64_t parts_required = 0;
  std::string software, boot_id;
  std::optional<std::int64_t> last_seen_ms;
  std::string live_json;  ///< last live state kept over a restart; empty: never heard of
  std::int64_t created_ms = 0;
};

struct ResidentRow {
  std::string name, sha256;
  std::int64_t bytes = 0;
  std::optional<std::int64_t> since_ms;
  bool selected = false;
  std::int64_t reported_ms = 0;
  std::int64_t program_id = 0, revision = 0;  ///< 0: this content is not in the library
  bool stale = false;                         ///< in the library, but not the released revision
};

struct OffsetRow {
  std::string what;
  double value = 0;
  std::int64_t at_ms = 0;
};

std::vector<MachineRow> machines(Database& db);
std::optional<MachineRow> machine(Database& db, std::int64_t id);
std::int64_t insert_machine(Database& db, const MachineRow& machine);
/// Writes name, profile, toml, config_hash and parts_required.
void update_machine(Database& db, const MachineRow& machine);
/// Keeps all history; the name becomes free, certificates and tokens are no longer valid.
void remove_machine(Database& db, std::int64_t id, std::int64_t at_ms);

void insert_token(Database& db, std::int64_t machine, const std::string& secret_sha256, const std::string& by,
                  std::int64_t created_ms, std::int64_t expires_ms);
/// @return the machine, 0 when unknown, used or expired. Marks it used.
std::int64_t use_token(Database& db, const std::string& secret_sha256, std::int64_t at_ms);
/// Revokes the machine's other certificates.
void insert_certificate(Database& db, std::int64_t machine, const std::string& serial, std::int64_t at_ms);
bool certificate_valid(Database& db, std::int64_t machine, const std::string& serial);

void replace_residents(Database& db, std::int64_t machine, const std::vector<ResidentRow>& programs,
                       std::int64_t at_ms);
std::vector<ResidentRow> residents(Database& db, std::int64_t machine);
std::vector<OffsetRow> offsets(Database& db, std::int64_t machine);

}  // namespace headstock::db
