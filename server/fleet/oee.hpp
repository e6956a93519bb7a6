// Availability, performance, quality and their product, from the server's own record: the state intervals,
// the parts, the rejects, the shifts. Every figure comes with what was counted for it. Store thread.
//
//   planned      scheduled time (shifts; all of it when the shop has none) minus stops with a planned reason,
//   minus
//                the time nobody knows about (`unknown`): that is reported beside, never taken as standing or
//                running
//   availability running ÷ planned          performance  ideal time of the parts ÷ running
//   quality      good ÷ all parts           oee          their product
// What has nothing to divide by is unknown, not 0.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "db/database.hpp"
#include "server/fleet/downtime.hpp"
#include "server/fleet/shifts.hpp"

namespace headstock::fleet {

inline constexpr std::array<std::string_view, 9> kStates = {
    "running", "hold", "stopped", "idle", "alarm", "emergency_stop", "setup", "off", "unknown"};

struct Figures {
  std::int64_t scheduled_ms = 0;
  std::array<std::int64_t, kStates.size()> in_state_ms{};  ///< within the scheduled time, by kStates
  std::int64_t planned_stop_ms = 0;                        ///< not running, with a planned reason
  std::int64_t unrecorded_ms = 0;                          ///< before the machine was first heard of
  std::map<std::int64_t, std::int64_t> by_reason_ms;       ///< not running, by downtime reason
  std::int64_t unexplained_ms = 0;                         ///< not running, known, without a reason
  std::int64_t parts = 0, rejects = 0;
  std::int64_t parts_without_ideal = 0;  ///< no check predicted their time: not in the performance
  double ideal_ms = 0;

  std::int64_t running_ms() const { return in_state_ms[0]; }
  std::int64_t unknown_ms() const { return in_state_ms[kStates.size() - 1] + unrecorded_ms; }
  std::int64_t planned_ms() const { return scheduled_ms - planned_stop_ms - unknown_ms(); }
  std::optional<double> availability() const;
  std::optional<double> performance() const;
  std::optional<double> quality() const;
  std::optional<double> oee() const;
};

/// A line of the report: one machine in one stretch.
struct OeeRow {
  std::int64_t machine = 0;
  Span span;               ///< clipped to what was asked and to now
  std::string day, shift;  ///< local date; name of the shift; empty where they do not apply
  Figures figures;
};

enum class OeeBy { machine, day, week, shift };

/// @param machine 0: all. By machine first, then by time. Refuses more than 400 days.
std::vector<OeeRow> oee(db::Database& db, std::int64_t machine, const Span& within, OeeBy by,
                        std::int64_t now_ms);

/// How often and how long each alarm was there; those with most time first.
struct AlarmFigures {
  std::string code, text_en, text_zh;
  std::int64_t count = 0, active_ms = 0, machines = 0;
  std::int64_t last_ms = 0;
};
std::vector<AlarmFigures> alarm_figures(db::Database& db, std::int64_t machine, const Span& within,
                                        std::int64_t now_ms);

}  // namespace headstock::fleet
