// Rows of the store as the JSON of README.md: times as ISO 8601, unknown as null. schemas.json describes the same shapes
// for the served OpenAPI document.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "db/page.hpp"
#include "server/access/accounts.hpp"
#include "server/library/difference.hpp"

namespace headstock::db {
struct MachineRow;
struct ResidentRow;
struct OffsetRow;
struct ProgramRow;
struct RevisionRow;
struct TransferRow;
struct DistributionRow;
struct AlarmRow;
struct PartRow;
struct RunRow;
struct StateRow;
struct AuditRow;
struct ValueItem;
struct ValueRequestRow;
struct ValueChangeRow;
struct SnapshotRow;
}  // namespace headstock::db

namespace headstock::library {
struct Backplot;
}
namespace headstock::fleet {
struct SheetRow;
struct LifeGroupView;
struct Disagreement;
struct Recount;
struct Order;
}  // namespace headstock::fleet

namespace headstock::api {

using nlohmann::json;

json time_json(std::int64_t ms);
json time_json(const std::optional<std::int64_t>& ms);

json to_json(const access::User& user);
/// With its axes and limits when `detailed` (reads the machine file).
json to_json(const db::MachineRow& machine, bool detailed);
json to_json(const db::ResidentRow& resident);
json to_json(const db::OffsetRow& offset);
json to_json(const db::ProgramRow& program);
json to_json(const db::RevisionRow& revision);
json to_json(const db::TransferRow& transfer);
json to_json(const db::DistributionRow& distribution);
json to_json(const db::AlarmRow& alarm);
json to_json(const db::PartRow& part);
json to_json(const db::RunRow& run);
json to_json(const db::StateRow& state);
json to_json(const db::AuditRow& row);
// routes/value_shapes.cpp
json to_json(const db::ValueItem& item);
json to_json(const db::ValueRequestRow& request);
json to_json(const db::ValueChangeRow& change);
json to_json(const db::SnapshotRow& snapshot);
json to_json(const fleet::SheetRow& row);
json to_json(const fleet::LifeGroupView& group);
json to_json(const fleet::Disagreement& disagreement);
json to_json(const fleet::Recount& recount);
json to_json(const fleet::Order& order);
json to_json(const library::Difference& difference);
json to_json(const library::Backplot& backplot);

/// `{"items":[…],"next":"cursor"|null}`
template <class Rows>
json list_json(const Rows& rows, const std::optional<std::int64_t>& next = std::nullopt) {
  json items = json::array();
  for (const auto& row : rows) items.push_back(to_json(row));
  json list = {{"items", std::move(items)}, {"next", nullptr}};
  if (next) list["next"] = std::to_string(*next);
  return list;
}
template <class T>
json list_json(const db::Listed<T>& listed) {
  return list_json(listed.items, listed.next);
}

}  // namespace headstock::api
