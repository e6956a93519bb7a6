// What machines have in their pages, as the machines tell it: every change with who and what, and now and
// then everything they have, which is held against it. The machine is the truth of what it has. Store thread.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "db/event_store.hpp"
#include "db/machine_store.hpp"
#include "db/value_store.hpp"
#include "dialects/data_rules.hpp"
#include "interpreter/machine_data.hpp"

namespace headstock::fleet {

/// An event of kind "offset". Inside the transaction of the event.
void record_change(db::Database& db, const db::EventRow& event, const nlohmann::json& body);

/// Writes the machine's offsets as the document that `headstock interpret --offsets` reads, and gives them a
/// new version when a check of a program could come out otherwise with them.
void rebuild_offsets(db::Database& db, std::int64_t machine, std::int64_t now_ms);

/// A data_report: everything set, as it was when the event `sequence` of the spool had been written. What
/// differs from what the events told becomes a change of origin "found".
/// @return how many differences there were; of a machine never heard of before everything is "found" and none
/// counts.
std::int64_t reconcile(db::Database& db, std::int64_t machine, const std::string& spool,
                       const nlohmann::json& report, std::int64_t now_ms);

/// A machine's data as its interpreter would have them, with the axes and rules they belong to.
struct MachinePages {
  db::MachineRow machine;
  std::vector<char> axes;
  interp::MachineData data;
  const dialects::Dialect* dialect = nullptr;
  dialects::OffsetPage page;
};
/// Refusals: not_found, bad_machine_file.
MachinePages machine_pages(db::Database& db, std::int64_t machine);

/// Rules that hold whatever the machine is doing; the rest it says itself.
inline constexpr dialects::Situation kAnyTime{false, true, true};
/// As the machine compares (operation/data_edit.cpp): what a page shows alike is alike.
bool same_as_shown(std::optional<double> a, std::optional<double> b);

/// "offsets" "work" "parameters" "variables" "tool_life" or "" for all: does this value belong to it?
bool in_kind(const std::string& kind, const std::string& what);
/// Which limit holds for a value: wear geometry radius work variable parameter tool_life; empty: none ever
/// (tips).
std::string limit_kind(const std::string& what);

}  // namespace headstock::fleet
