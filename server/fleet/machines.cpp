#include "server/fleet/machines.hpp"

#include "db/hash.hpp"
#include "db/refusal.hpp"
#include "machine/machine.hpp"
#include "server/access/audit.hpp"
#include "server/library/programs.hpp"

namespace headstock::fleet {
namespace {

using access::Action;
using access::Actor;
using access::demand;
using access::record;

void demand_usable_file(const std::string& toml, const std::string& profile) {
  if (!machine::default_machine(profile)) throw db::Refusal("bad_profile", profile.substr(0, 60));
  if (toml.empty()) return;
  if (toml.size() > (64u << 10)) throw db::Refusal("too_large", "machine file");
  const auto parsed = machine::parse_machine(toml, "machine", profile);
  if (const auto* error = std::get_if<machine::MachineError>(&parsed))
    throw db::Refusal("bad_machine_file", error->message);
}

void demand_free_name(db::Database& db, const std::string& name, std::int64_t except) {
  if (db.integer("SELECT 1 FROM machines WHERE name = ? AND removed_ms IS NULL AND id <> ?", {name, except}))
    throw db::Refusal("name_taken", name);
}

}  // namespace

std::string config_hash(const std::string& profile, const std::string& toml) {
  return db::sha256_hex(profile + '\n' + toml);
}

db::MachineRow require_machine(db::Database& db, std::int64_t id) {
  auto row = db::machine(db, id);
  if (!row) throw db::Refusal("not_found", access::subject("machine", id));
  return *row;
}

db::MachineRow create_machine(db::Database& db, const Actor& actor, const std::string& name,
                              const std::string& profile, const std::string& toml, std::int64_t now_ms) {
  demand(actor, Action::manage_machines);
  library::demand_good_name(name);
  demand_usable_file(toml, profile);
  db::Transaction transaction(db);
  demand_free_name(db, name, 0);
  db::MachineRow row;
  row.name = name;
  row.profile = profile;
  row.toml = toml;
  row.config_hash = config_hash(profile, toml);
  row.created_ms = now_ms;
  row.id = db::insert_machine(db, row);
  record(db, actor, "machine.create", access::subject("machine", row.id), {{"name", name}, {"profile", profile}});
  row = require_machine(db, row.id);
  transaction.commit();
  return row;
}

db::MachineRow change_machine(db::Database& db, const Actor& actor, std::int64_t id,
                              const MachineChange& change, std::int64_t /*now_ms*/) {
  demand(actor, Action::edit_machine);
  db::Transaction transaction(db);
  db::MachineRow row = require_machine(db, id);
  if (change.name) {
    library::demand_good_name(*change.name);
    demand_free_name(db, *change.name, id);
    row.name = *change.name;
  }
  if (change.toml) {
    demand_usable_file(*change.toml, row.profile);
    row.toml = *change.toml;
    row.config_hash = config_hash(row.profile, row.toml);
  }
  if (change.parts_required) {
    if (*change.parts_required < 0 || *change.parts_required > 99'999'999)
      throw db::Refusal("bad_value", "parts_required");
    row.parts_required = *change.parts_required;
  }
  db::update_machine(db, row);
  record(db, actor, "machine.change", access::subject("machine", id),
         {{"name", row.name},
          {"config", row.config_hash},
          {"parts_required", std::to_string(row.parts_required)}});
  transaction.commit();
  return row;
}

void remove_machine(db::Database& db, const Actor& actor, std::int64_t id, std::int64_t now_ms) {
  demand(actor, Action::manage_machines);
  db::Transaction transaction(db);
  const db::MachineRow row = require_machine(db, id);
  db::remove_machine(db, id, now_ms);
  record(db, actor, "machine.remove", access::subject("machine", id), {{"name", row.name}});
  transaction.commit();
}

std::string issue_token(db::Database& db, const Actor& actor, std::int64_t machine, std::int64_t now_ms) {
  demand(actor, Action::enrol_machine);
  db::Transaction transaction(db);
  require_machine(db, machine);
  const std::string secret = db::random_hex(24);
  db::insert_token(db, machine, db::sha256_hex(secret), actor.user, now_ms, now_ms + kTokenLifeMs);
  record(db, actor, "machine.token", access::subject("machine", machine));
  transaction.commit();
  return secret;
}

}  // namespace headstock::fleet
