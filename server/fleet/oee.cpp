#include "server/fleet/oee.hpp"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "db/event_store.hpp"
#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "server/fleet/machines.hpp"

namespace headstock::fleet {
namespace {

constexpr std::int64_t kLongestMs = 400LL * 86'400'000;

std::size_t index_of(const std::string& state) {
  const auto* found = std::ranges::find(kStates, state);
  return found == kStates.end() ? kStates.size() - 1 : static_cast<std::size_t>(found - kStates.begin());
}

std::optional<double> ratio(double part, double whole) {
  if (whole <= 0) return std::nullopt;
  return part / whole;
}

Span common(const Span& a, const Span& b) {
  return {std::max(a.from_ms, b.from_ms), std::min(a.to_ms, b.to_ms)};
}

/// One machine's record of the time that was asked for, each kind in the order of time.
struct Record {
  std::vector<db::StateRow> states;
  std::vector<DowntimeNote> notes;
  struct Part {
    std::int64_t at_ms;
    double ideal_ms;  ///< 0: nobody predicted it
  };
  std::vector<Part> parts;
  std::vector<Reject> rejects;
};

/// The predicted time of a content on a machine, as its newest good check said; 0: never checked.
std::map<std::string, double> ideal_times(db::Database& db, std::int64_t machine, const Span& within) {
  std::map<std::string, double> times;
  db.each(
      "SELECT c.sha256, c.result_json FROM checks c WHERE c.machine_id = ? AND c.ok = 1 AND c.sha256 IN "
      "(SELECT DISTINCT sha256 FROM parts WHERE machine_id = ? AND at_ms >= ? AND at_ms < ?) ORDER BY c.id",
      {machine, machine, within.from_ms, within.to_ms}, [&](const db::Row& row) {
        const auto result = nlohmann::json::parse(row.text(1), nullptr, false);
        if (result.is_object()) times[row.text(0)] = result.value("time_s", 0.0) * 1000;
      });
  return times;
}

Record read(db::Database& db, std::int64_t machine, const Span& within) {
  Record record;
  db::HistoryFilter filter;
  filter.machine = machine;
  filter.from_ms = within.from_ms;
  filter.to_ms = within.to_ms;
  db::each_state(db, filter, [&](const db::StateRow& state) { record.states.push_back(state); });
  record.notes = settled(downtime_notes(db, machine, within));
  const auto ideal = ideal_times(db, machine, within);
  db.each("SELECT at_ms, sha256 FROM parts WHERE machine_id = ? AND at_ms >= ? AND at_ms < ? ORDER BY at_ms",
          {machine, within.from_ms, within.to_ms}, [&](const db::Row& row) {
            const auto known = ideal.find(row.text(1));
            record.parts.push_back({row.integer(0), known == ideal.end() ? 0 : known->second});
          });
  record.rejects = rejects(db, machine, within);
  return record;
}

/// Adds what a stop of one state within one scheduled span was: by reason, planned or unexplained.
void add_stop(Figures& figures, const std::vector<DowntimeNote>& notes, const Span& stop) {
  std::int64_t explained = 0;
  // Notes without overlap are in order at both ends.
  auto note =
      std::ranges::upper_bound(notes, stop.from_ms, {}, [](const DowntimeNote& one) { return one.to_ms; });
  for (; note != notes.end() && note->from_ms < stop.to_ms; ++note) {
    const std::int64_t length = common(*note, stop).length_ms();
    explained += length;
    figures.by_reason_ms[*note->reason] += length;
    if (note->planned) figures.planned_stop_ms += length;
  }
  figures.unexplained_ms += stop.length_ms() - explained;
}

void add_scheduled(Figures& figures, const Record& record, const Span& scheduled) {
  figures.scheduled_ms += scheduled.length_ms();
  std::int64_t recorded = 0;
  auto state = std::ranges::upper_bound(record.states, scheduled.from_ms, {}, [](const db::StateRow& row) {
    return row.to_ms.value_or(std::numeric_limits<std::int64_t>::max());
  });
  for (; state != record.states.end() && state->from_ms < scheduled.to_ms; ++state) {
    const Span span = common(scheduled, {state->from_ms, state->to_ms.value_or(scheduled.to_ms)});
    if (span.length_ms() == 0) continue;
    recorded += span.length_ms();
    figures.in_state_ms[index_of(state->state)] += span.length_ms();
    if (state->state != "running" && state->state != "unknown") add_stop(figures, record.notes, span);
  }
  figures.unrecorded_ms += scheduled.length_ms() - recorded;
}

void add_parts(Figures& figures, const Record& record, const Span& span) {
  auto part = std::ranges::lower_bound(record.parts, span.from_ms, {}, &Record::Part::at_ms);
  for (; part != record.parts.end() && part->at_ms < span.to_ms; ++part) {
    ++figures.parts;
    if (part->ideal_ms > 0)
      figures.ideal_ms += part->ideal_ms;
    else
      ++figures.parts_without_ideal;
  }
  auto reject = std::ranges::lower_bound(record.rejects, span.from_ms, {}, &Reject::at_ms);
  for (; reject != record.rejects.end() && reject->at_ms < span.to_ms; ++reject)
    figures.rejects += reject->quantity;
}

std::vector<ShiftSpan> rows_of(const Calendar& calendar, const Span& within, OeeBy by) {
  switch (by) {
    case OeeBy::day:
      return local_days(calendar.time_zone, within);
    case OeeBy::week:
      return local_weeks(calendar.time_zone, within);
    case OeeBy::shift:
      // A shop without shifts works in days.
      return calendar.shifts.empty() ? local_days(calendar.time_zone, within) : shift_spans(calendar, within);
    case OeeBy::machine:
      break;
  }
  ShiftSpan all;
  all.from_ms = within.from_ms;
  all.to_ms = within.to_ms;
  return {all};
}

}  // namespace

std::optional<double> Figures::availability() const {
  return ratio(static_cast<double>(running_ms()), static_cast<double>(planned_ms()));
}
std::optional<double> Figures::performance() const {
  if (parts_without_ideal != 0) return std::nullopt;
  return ratio(ideal_ms, static_cast<double>(running_ms()));
}
std::optional<double> Figures::quality() const {
  return ratio(static_cast<double>(std::max<std::int64_t>(parts - rejects, 0)), static_cast<double>(parts));
}
std::optional<double> Figures::oee() const {
  const auto a = availability(), p = performance(), q = quality();
  if (!a || !p || !q) return std::nullopt;
  return *a * *p * *q;
}

std::vector<OeeRow> oee(db::Database& db, std::int64_t machine, const Span& asked, OeeBy by,
                        std::int64_t now_ms) {
  if (asked.to_ms <= asked.from_ms || asked.length_ms() > kLongestMs) throw db::Refusal("bad_value", "to");
  const Calendar calendar = read_calendar(db);
  const Span within = {asked.from_ms, std::min(asked.to_ms, now_ms)};
  std::vector<OeeRow> rows;
  if (within.length_ms() == 0) return rows;
  const auto scheduled = calendar.shifts.empty() ? std::vector<ShiftSpan>{} : shift_spans(calendar, within);
  const auto stretches = rows_of(calendar, within, by);

  std::vector<std::int64_t> ids;
  if (machine != 0)
    ids.push_back(require_machine(db, machine).id);
  else
    for (const db::MachineRow& row : db::machines(db)) ids.push_back(row.id);

  for (const std::int64_t id : ids) {
    const Record record = read(db, id, within);
    for (const ShiftSpan& stretch : stretches) {
      OeeRow row;
      row.machine = id;
      row.span = common(stretch, within);
      if (row.span.length_ms() == 0) continue;
      row.day = stretch.day;
      if (by == OeeBy::shift && !calendar.shifts.empty()) {
        row.shift = calendar.shifts[stretch.shift].name;
        add_scheduled(row.figures, record, row.span);
      } else if (calendar.shifts.empty()) {
        add_scheduled(row.figures, record, row.span);
      } else {
        for (const ShiftSpan& shift : scheduled) {
          const Span part = common(shift, row.span);
          if (part.length_ms() > 0) add_scheduled(row.figures, record, part);
        }
      }
      add_parts(row.figures, record, row.span);
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

std::vector<AlarmFigures> alarm_figures(db::Database& db, std::int64_t machine, const Span& within,
                                        std::int64_t now_ms) {
  std::vector<AlarmFigures> figures;
  const std::string only = machine == 0 ? "" : " AND machine_id = ?";
  db::Values values = {now_ms, within.from_ms, within.to_ms};
  if (machine != 0) values.emplace_back(require_machine(db, machine).id);
  db.each(
      "SELECT code, MAX(text_en), MAX(text_zh), COUNT(*), SUM(COALESCE(cleared_ms, ?) - raised_ms), "
      "COUNT(DISTINCT machine_id), MAX(raised_ms) FROM alarms WHERE raised_ms >= ? AND raised_ms < ?" +
          only + " GROUP BY code ORDER BY 5 DESC, code",
      values, [&](const db::Row& row) {
        figures.push_back({row.text(0), row.text(1), row.text(2), row.integer(3), row.integer(4),
                           row.integer(5), row.integer(6)});
      });
  return figures;
}

}  // namespace headstock::fleet
