// Offsets, tool life, parameters and variables of the machines: what each has, how it came to that, what
// people asked to be written, limits and snapshots. Plain rows; the rules are in server/fleet. Store thread.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "db/page.hpp"

namespace headstock::db {

/// By name (controller-agent/interpreter/data_values.hpp); what is not set is not in it.
using MachineValues = std::map<std::string, double>;

struct ValueChangeRow {
  std::int64_t id = 0, machine = 0;
  std::string spool;
  std::optional<std::int64_t>
      sequence;  ///< of the event; nothing: found when the machine reported all it has
  std::int64_t at_ms = 0, received_ms = 0;
  std::string what;
  std::optional<double> before, after;  ///< nothing: not set
  std::string
      origin;  ///< G10, measurement, program, panel, person, import, copy, restore, compensation, found
  std::string by;
  std::int64_t request = 0;
};
void insert_value_change(Database& db, const ValueChangeRow& change);
struct ValueChangeFilter {
  std::int64_t machine = 0;  ///< 0: all
  std::string what;          ///< exactly, or what begins so when it ends in "/"; empty: all
  std::optional<std::int64_t> from_ms, to_ms;
};
Listed<ValueChangeRow> value_changes(Database& db, const ValueChangeFilter& filter, const Page& page);
bool request_was_carried_out(Database& db, std::int64_t request);

/// Everything set now, or (with `at_ms`) as it was then by the changes' own times.
MachineValues machine_values(Database& db, std::int64_t machine,
                             std::optional<std::int64_t> at_ms = std::nullopt);
/// The value now, unless the same spool has told a later one.
void put_value(Database& db, std::int64_t machine, const std::string& what, std::optional<double> value,
               const std::string& spool, std::int64_t sequence, std::int64_t at_ms);

struct ValueItem {
  std::string what;
  std::optional<double> before, after, read_back;
  bool was_read = false;
};
struct ValueRequestRow {
  std::int64_t id = 0, machine = 0;
  std::string by;
  std::int64_t at_ms = 0;
  std::string origin, why, state;
  std::string needs_second;  ///< the value whose step is above the limit; empty: one person is enough
  std::string second;
  std::optional<std::int64_t> second_ms;
  std::string reason, where;
  std::optional<std::int64_t> ended_ms;
  std::vector<ValueItem> items;
};
std::int64_t insert_value_request(Database& db, const ValueRequestRow& request);
/// Writes state, second person, reason, where and end, and the read-back of its items.
void update_value_request(Database& db, const ValueRequestRow& request);
std::optional<ValueRequestRow> value_request(Database& db, std::int64_t id);
struct ValueRequestFilter {
  std::int64_t machine = 0;
  std::string state;
  bool open_only = false;
};
Listed<ValueRequestRow> value_requests(Database& db, const ValueRequestFilter& filter, const Page& page);

/// By kind; the machine's own where it has one, otherwise the shop's.
std::map<std::string, double> value_limits(Database& db, std::int64_t machine);
/// Nothing: no limit of its own any more (machine), none (shop, machine 0).
void put_value_limit(Database& db, std::int64_t machine, const std::string& kind, std::optional<double> step);

struct SnapshotRow {
  std::int64_t id = 0, machine = 0;
  std::string profile, name, by;
  std::int64_t at_ms = 0, values = 0;
};
std::int64_t insert_snapshot(Database& db, const SnapshotRow& snapshot, const MachineValues& values);
std::vector<SnapshotRow> snapshots(Database& db, std::int64_t machine);
std::optional<SnapshotRow> snapshot(Database& db, std::int64_t id);
MachineValues snapshot_values(Database& db, std::int64_t id);

}  // namespace headstock::db
