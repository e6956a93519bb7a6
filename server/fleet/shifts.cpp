#include "server/fleet/shifts.hpp"

#include <date/tz.h>

#include <algorithm>

#include "db/refusal.hpp"
#include "server/access/audit.hpp"

namespace headstock::fleet {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;

constexpr const char* kZoneSetting = "time_zone";
constexpr std::size_t kMostShifts = 50;
constexpr int kMinutesOfWeek = 7 * 1440;

const date::time_zone& zone_named(const std::string& name) {
  try {
    return *date::locate_zone(name);
  } catch (const std::exception&) {
    throw db::Refusal("bad_value", "time_zone");
  }
}

date::local_days local_day(const date::time_zone& zone, std::int64_t at_ms) {
  const date::sys_time<milliseconds> at{milliseconds(at_ms)};
  return date::floor<date::days>(zone.to_local(at));
}

/// A clock time that happens twice is the earlier, one that does not happen is where the clock jumps.
std::int64_t to_ms(const date::time_zone& zone, date::local_days day, int minute) {
  const auto moment =
      zone.to_sys(date::local_time<milliseconds>(day + minutes(minute)), date::choose::earliest);
  return std::chrono::duration_cast<milliseconds>(moment.time_since_epoch()).count();
}

std::string text_of(date::local_days day) {
  return date::format("%F", day);
}

/// Monday 0 … Sunday 6.
unsigned weekday_of(date::local_days day) {
  return date::weekday(day).iso_encoding() - 1;
}

int length_of(const Shift& shift) {
  const int length = shift.end_minute - shift.start_minute;
  return length > 0 ? length : length + 1440;
}

std::vector<ShiftSpan> whole_days(const std::string& time_zone, const Span& within, int step,
                                  bool from_monday) {
  const date::time_zone& zone = zone_named(time_zone);
  std::vector<ShiftSpan> spans;
  auto day = local_day(zone, within.from_ms);
  if (from_monday) day -= date::days(weekday_of(day));
  while (to_ms(zone, day, 0) < within.to_ms) {
    ShiftSpan span;
    span.from_ms = to_ms(zone, day, 0);
    span.to_ms = to_ms(zone, day + date::days(step), 0);
    span.day = text_of(day);
    if (span.to_ms > within.from_ms) spans.push_back(span);
    day += date::days(step);
  }
  return spans;
}

void demand_no_overlap(const std::vector<Shift>& shifts) {
  // In minutes of the week; what runs beyond Sunday night meets Monday morning.
  struct Piece {
    int from, to;
  };
  std::vector<Piece> pieces;
  for (const Shift& shift : shifts) {
    for (int day = 0; day < 7; ++day) {
      if ((shift.days >> day & 1) == 0) continue;
      const int from = day * 1440 + shift.start_minute, to = from + length_of(shift);
      pieces.push_back({from, std::min(to, kMinutesOfWeek)});
      if (to > kMinutesOfWeek) pieces.push_back({0, to - kMinutesOfWeek});
    }
  }
  std::ranges::sort(pieces, {}, &Piece::from);
  for (std::size_t i = 1; i < pieces.size(); ++i)
    if (pieces[i].from < pieces[i - 1].to) throw db::Refusal("shifts_overlap");
}

}  // namespace

std::string system_time_zone() {
  try {
    return date::current_zone()->name();
  } catch (const std::exception&) {
    return "Etc/UTC";
  }
}

std::vector<ShiftSpan> shift_spans(const Calendar& calendar, const Span& within) {
  const date::time_zone& zone = zone_named(calendar.time_zone);
  std::vector<ShiftSpan> spans;
  // A shift that began the evening before reaches into the first day.
  const auto last = local_day(zone, within.to_ms);
  for (auto day = local_day(zone, within.from_ms) - date::days(1); day <= last; day += date::days(1)) {
    for (std::size_t i = 0; i < calendar.shifts.size(); ++i) {
      const Shift& shift = calendar.shifts[i];
      if ((shift.days >> weekday_of(day) & 1) == 0) continue;
      ShiftSpan span;
      span.from_ms = to_ms(zone, day, shift.start_minute);
      span.to_ms = to_ms(zone, day, shift.start_minute + length_of(shift));
      span.shift = i;
      span.day = text_of(day);
      if (span.to_ms > within.from_ms && span.from_ms < within.to_ms) spans.push_back(span);
    }
  }
  std::ranges::sort(spans, {}, &ShiftSpan::from_ms);
  return spans;
}

std::vector<ShiftSpan> local_days(const std::string& time_zone, const Span& within) {
  return whole_days(time_zone, within, 1, false);
}

std::vector<ShiftSpan> local_weeks(const std::string& time_zone, const Span& within) {
  return whole_days(time_zone, within, 7, true);
}

Calendar read_calendar(db::Database& db) {
  Calendar calendar;
  const auto zone = db.text("SELECT value FROM settings WHERE key = ?", {kZoneSetting});
  calendar.time_zone = zone ? *zone : system_time_zone();
  db.each("SELECT name, days, start_minute, end_minute FROM shifts ORDER BY id", {}, [&](const db::Row& row) {
    calendar.shifts.push_back({row.text(0), static_cast<std::uint8_t>(row.integer(1)),
                               static_cast<int>(row.integer(2)), static_cast<int>(row.integer(3))});
  });
  return calendar;
}

void write_calendar(db::Database& db, const access::Actor& actor, const Calendar& calendar) {
  access::demand(actor, access::Action::edit_calendar);
  zone_named(calendar.time_zone);
  if (calendar.shifts.size() > kMostShifts) throw db::Refusal("bad_value", "shifts");
  for (const Shift& shift : calendar.shifts) {
    if (shift.name.empty() || shift.name.size() > 100) throw db::Refusal("bad_value", "name");
    if (shift.days == 0 || shift.days > 127) throw db::Refusal("bad_value", "days");
    if (shift.start_minute < 0 || shift.start_minute > 1439) throw db::Refusal("bad_value", "start");
    if (shift.end_minute < 0 || shift.end_minute > 1439) throw db::Refusal("bad_value", "end");
  }
  demand_no_overlap(calendar.shifts);
  db::Transaction transaction(db);
  db.execute(
      "INSERT INTO settings (key, value) VALUES (?, ?) ON CONFLICT (key) DO UPDATE SET value = "
      "excluded.value",
      {kZoneSetting, calendar.time_zone});
  db.execute("DELETE FROM shifts");
  for (const Shift& shift : calendar.shifts)
    db.execute("INSERT INTO shifts (name, days, start_minute, end_minute) VALUES (?, ?, ?, ?)",
               {shift.name, static_cast<int>(shift.days), shift.start_minute, shift.end_minute});
  access::record(db, actor, "calendar.change", "calendar",
                 {{"time_zone", calendar.time_zone}, {"shifts", std::to_string(calendar.shifts.size())}});
  transaction.commit();
}

}  // namespace headstock::fleet
