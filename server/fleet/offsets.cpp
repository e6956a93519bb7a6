#include "server/fleet/offsets.hpp"

#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "db/machine_store.hpp"

namespace headstock::fleet {
namespace {

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts;
  std::istringstream stream(path);
  for (std::string part; std::getline(stream, part, '/');) parts.push_back(part);
  return parts;
}

/// Where a reported value stands in the document; empty: it does not belong there (parameters, variables).
std::vector<std::string> place_in_document(const std::string& what) {
  std::vector<std::string> parts = split(what);
  if (parts.size() < 3) return {};
  if (parts[0] == "tool") {
    parts[0] = "tools";
    return parts;
  }
  if (parts[0] != "work") return {};
  if (parts[1] == "EXT") return {"external", parts[2]};
  if (parts[1] == "shift") return {"shift", parts[2]};
  return parts;
}

}  // namespace

void record_offset(db::Database& db, const db::EventRow& event, const OffsetChange& change) {
  db.execute(
      "INSERT INTO offset_changes (machine_id, spool, sequence, at_ms, what, before_value, after_value, "
      "origin) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
      {event.machine, event.spool, event.sequence, event.at_ms, change.what, change.before, change.after,
       change.origin});
  // A late event does not undo a newer value.
  db.execute(
      "INSERT INTO offsets (machine_id, what, value, at_ms) VALUES (?, ?, ?, ?) ON CONFLICT (machine_id, "
      "what) "
      "DO UPDATE SET value = excluded.value, at_ms = excluded.at_ms WHERE excluded.at_ms >= offsets.at_ms",
      {event.machine, change.what, change.after, event.at_ms});
}

void rebuild_offsets(db::Database& db, std::int64_t machine, std::int64_t now_ms) {
  nlohmann::json document = nlohmann::json::object();
  for (const db::OffsetRow& row : db::offsets(db, machine)) {
    const std::vector<std::string> place = place_in_document(row.what);
    if (place.empty()) continue;
    nlohmann::json* at = &document;
    for (const std::string& key : place) {
      if (!at->is_object() && !at->is_null()) break;
      at = &(*at)[key];
    }
    *at = row.value;
  }
  db.execute(
      "UPDATE machines SET offsets_json = ?, offsets_version = offsets_version + 1, offsets_at_ms = ? WHERE "
      "id = ?",
      {document.dump(), now_ms, machine});
}

}  // namespace headstock::fleet
