#include "server/dnc/ports.hpp"

#include <nlohmann/json.hpp>

#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "protocol/serial/port/port.hpp"
#include "server/access/audit.hpp"
#include "server/dnc/agent_port.hpp"
#include "server/dnc/settings.hpp"
#include "server/library/programs.hpp"

namespace headstock::dnc {
namespace {

using nlohmann::json;

template <class T>
T field(const json& fields, const char* name, const T& otherwise) {
  if (!fields.contains(name) || fields[name].is_null()) return otherwise;
  try {
    return fields[name].get<T>();
  } catch (const json::exception&) {
    throw db::Refusal("bad_value", name);
  }
}

/// The server opens what is written here: devices, nothing else of the file system.
void demand_line(const std::string& text) {
  const auto address = serial::address_of(text);
  if (!address || (address->kind == serial::PortAddress::tty && !address->device.starts_with("/dev/")))
    throw db::Refusal("bad_value", "address");
}

void take(db::Database& db, const json& fields, db::PortRow& port) {
  port.name = field(fields, "name", port.name);
  library::demand_good_name(port.name);
  const auto other = db::port_named(db, port.name);
  if (other && other->id != port.id) throw db::Refusal("name_taken", port.name);
  port.machine =
      fields.contains("machine") && fields["machine"].is_null() ? 0 : field(fields, "machine", port.machine);
  if (port.machine != 0 && !db::machine(db, port.machine)) throw db::Refusal("not_found", "machine");
  port.address = field(fields, "address", port.address);
  if (const auto agent = agent_of(port.address); agent != 0) {
    if (!db::machine(db, agent)) throw db::Refusal("not_found", "machine");
    port.machine = agent;
  } else {
    demand_line(port.address);
  }
  for (const auto& row : db::ports(db))
    if (row.id != port.id && row.address == port.address) throw db::Refusal("name_taken", "address");
  if (fields.contains("settings")) port.settings_json = to_json(settings_from(fields["settings"])).dump();
  port.listens = agent_of(port.address) == 0 && field(fields, "listens", port.listens);
  port.folder = library::clean_folder(field(fields, "folder", port.folder));
  port.name_rule = field(fields, "name_rule", port.name_rule);
  if (port.name_rule != "number" && port.name_rule != "comment") throw db::Refusal("bad_value", "name_rule");
  if (fields.contains("rules")) port.rules_json = to_json(rules_from(fields["rules"])).dump();
}

}  // namespace

db::PortRow require_port(db::Database& db, std::int64_t id) {
  auto port = db::port(db, id);
  if (!port) throw db::Refusal("not_found", "port");
  return *port;
}

db::PortRow create_port(db::Database& db, const access::Actor& actor, const json& fields,
                        std::int64_t now_ms) {
  access::demand(actor, access::Action::edit_machine);
  db::Transaction transaction(db);
  db::PortRow port;
  port.settings_json = to_json(settings_from(json::object())).dump();
  take(db, fields, port);
  port.created_ms = port.changed_ms = now_ms;
  port.id = db::insert_port(db, port);
  access::record(db, actor, "port.create", std::string("port:").append(std::to_string(port.id)),
                 {{"name", port.name}, {"address", port.address}});
  transaction.commit();
  return port;
}

db::PortRow change_port(db::Database& db, const access::Actor& actor, std::int64_t id, const json& fields,
                        std::int64_t now_ms) {
  access::demand(actor, access::Action::edit_machine);
  db::Transaction transaction(db);
  db::PortRow port = require_port(db, id);
  take(db, fields, port);
  port.changed_ms = now_ms;
  db::update_port(db, port);
  access::record(db, actor, "port.change", std::string("port:").append(std::to_string(id)),
                 {{"name", port.name}, {"address", port.address}, {"settings", port.settings_json}});
  transaction.commit();
  return port;
}

void remove_port(db::Database& db, const access::Actor& actor, std::int64_t id, std::int64_t now_ms) {
  access::demand(actor, access::Action::edit_machine);
  db::Transaction transaction(db);
  const db::PortRow port = require_port(db, id);
  db::remove_port(db, id, now_ms);
  access::record(db, actor, "port.remove", std::string("port:").append(std::to_string(id)),
                 {{"name", port.name}});
  transaction.commit();
}

}  // namespace headstock::dnc
