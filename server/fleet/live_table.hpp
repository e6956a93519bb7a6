// The newest word of every machine, with its age; and what the server knows besides: names, which program of
// the library this is, active alarms. Network thread only.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "db/event_store.hpp"
#include "db/machine_store.hpp"
#include "db/transfer_store.hpp"
#include "server/gateway/gateway.hpp"

namespace headstock::fleet {

/// What the library says of a content.
struct KnownProgram {
  std::int64_t id = 0, revision = 0;
  bool released = false;
};

struct Entry {
  db::MachineRow machine;
  nlohmann::json live;                      ///< as the agent sent it last; null: never
  std::optional<std::int64_t> received_ms;  ///< of that
  std::int64_t heard_ms = 0;                ///< any sign of life
  bool connected = false, shown_unknown = true, first_live = true;
  bool same_boot = true;         ///< as it was before the last connection
  bool parameter_write = false;  ///< its parameter switch, as last reported
  std::int64_t published_ms = 0, saved_ms = 0;
  std::vector<db::AlarmRow> alarms;  ///< active
  std::optional<server::TransferState> drip;
};

/// Does what it says now count as current?
bool is_current(const Entry& entry, std::int64_t now_ms);
/// `Live` as in server/api/README.md.
nlohmann::json live_json(const Entry& entry, const std::map<std::string, KnownProgram>& programs,
                         std::int64_t now_ms);
nlohmann::json alarm_json(const db::AlarmRow& alarm);
nlohmann::json part_json(const db::PartRow& part);
nlohmann::json run_json(const db::RunRow& run);

}  // namespace headstock::fleet
