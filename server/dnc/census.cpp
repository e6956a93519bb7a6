#include "server/dnc/census.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include "db/machine_store.hpp"
#include "db/port_store.hpp"
#include "db/program_store.hpp"
#include "server/dnc/agent_port.hpp"

namespace headstock::dnc {
namespace {

std::int64_t released_of(db::Database& db, std::int64_t program) {
  if (program == 0) return 0;
  const auto row = db::program(db, program);
  return row && row->released ? row->released->number : 0;
}

std::string state_of(const CensusEntry& entry) {
  if (entry.program == 0) return "unknown";
  if (!entry.classes.empty()) return "changed";
  return entry.revision == entry.released ? "released" : "older";
}

void add_agent(db::Database& db, const db::MachineRow& machine, std::vector<CensusEntry>& found) {
  for (const auto& resident : db::residents(db, machine.id)) {
    CensusEntry entry;
    entry.machine = machine.id;
    entry.machine_name = machine.name;
    entry.name = resident.name;
    entry.sha256 = resident.sha256;
    entry.program = resident.program_id;
    entry.revision = resident.revision;
    entry.released = released_of(db, entry.program);
    entry.proof = "reported";
    entry.since_ms = resident.since_ms.value_or(0);
    entry.proven_ms = resident.reported_ms;
    entry.state = state_of(entry);
    found.push_back(std::move(entry));
  }
}

void add_port(db::Database& db, const db::PortRow& port, const std::string& machine_name,
              std::vector<CensusEntry>& found) {
  std::map<std::string, db::PortResidentRow> newest;
  for (auto& row : db::port_residents(db, port.id)) {
    const auto known = newest.find(row.name);
    if (known == newest.end() || known->second.since_ms <= row.since_ms) newest[row.name] = std::move(row);
  }
  for (auto& [name, row] : newest) {
    CensusEntry entry;
    entry.machine = port.machine;
    entry.machine_name = machine_name;
    entry.port = port.id;
    entry.port_name = port.name;
    entry.name = name;
    entry.sha256 = row.sha256;
    entry.program = row.program;
    entry.revision = row.revision;
    entry.released = released_of(db, entry.program);
    entry.proof = row.punched ? "punched" : "sent";
    entry.classes = row.classes;
    // What was punched back may have become a revision since.
    if (const auto known = row.punched ? db::revision_of_content(db, row.sha256) : std::nullopt) {
      entry.program = known->program;
      entry.revision = known->number;
      entry.classes.clear();
    }
    entry.since_ms = entry.proven_ms = row.since_ms;
    entry.state = state_of(entry);
    found.push_back(std::move(entry));
  }
}

}  // namespace

std::vector<CensusEntry> census(db::Database& db, std::int64_t machine) {
  std::vector<CensusEntry> found;
  std::map<std::int64_t, std::string> names;
  for (const auto& row : db::machines(db)) {
    names[row.id] = row.name;
    if (machine == 0 || row.id == machine) add_agent(db, row, found);
  }
  for (const auto& port : db::ports(db)) {
    if (agent_of(port.address) != 0 || (machine != 0 && port.machine != machine)) continue;
    add_port(db, port, port.machine == 0 ? "" : names[port.machine], found);
  }
  std::ranges::sort(found, [](const CensusEntry& a, const CensusEntry& b) {
    return std::tie(a.machine_name, a.port_name, a.name) < std::tie(b.machine_name, b.port_name, b.name);
  });
  return found;
}

}  // namespace headstock::dnc
