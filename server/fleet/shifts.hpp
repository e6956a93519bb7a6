// When the shop works: shifts by the shop's own clock, turned into spans of time. A shift over a change to or
// from summer time is as long as it really is; a clock time that does not exist that night is the first that
// does. Any thread for the arithmetic, store thread for what reads and writes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "server/access/role.hpp"

namespace headstock::fleet {

/// [from_ms, to_ms) in Unix milliseconds.
struct Span {
  std::int64_t from_ms = 0, to_ms = 0;
  std::int64_t length_ms() const { return to_ms > from_ms ? to_ms - from_ms : 0; }
};

struct Shift {
  std::string name;
  std::uint8_t days = 0;  ///< bit 0: it begins on Mondays … bit 6: Sundays
  int start_minute = 0;   ///< of the day, 0…1439
  int end_minute = 0;     ///< of the same day, or of the next when not after the start
};

struct Calendar {
  std::string time_zone = "Etc/UTC";  ///< IANA name
  std::vector<Shift> shifts;          ///< empty: works always
};

/// One shift on one day.
struct ShiftSpan : Span {
  std::size_t shift = 0;  ///< index in Calendar::shifts
  std::string day;        ///< local date on which it began, "2026-03-29"
};

/// All that touch `within`, by their beginning; whole, not clipped. Throws db::Refusal("bad_value") for an
/// unknown time zone.
std::vector<ShiftSpan> shift_spans(const Calendar& calendar, const Span& within);
/// The local days that touch `within`, each with its date as name. 23 and 25 hours long when clocks change.
std::vector<ShiftSpan> local_days(const std::string& time_zone, const Span& within);
/// Weeks from Monday to Sunday, named by their Monday.
std::vector<ShiftSpan> local_weeks(const std::string& time_zone, const Span& within);

Calendar read_calendar(db::Database& db);
/// Replaces it. Refuses unknown zones, empty names, no day, shifts that overlap each other.
void write_calendar(db::Database& db, const access::Actor& actor, const Calendar& calendar);
/// The zone of the computer, for a shop that never chose.
std::string system_time_zone();

}  // namespace headstock::fleet
