// Times, reasons, rejects and the figures made of them.
#include <algorithm>

#include "db/store.hpp"
#include "db/time.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/fleet/downtime.hpp"
#include "server/fleet/machines.hpp"
#include "server/fleet/oee.hpp"
#include "server/fleet/shifts.hpp"

namespace headstock::api {

namespace {

using access::Action;
using boost::asio::awaitable;

json as_seconds(std::int64_t ms) { return static_cast<double>(ms) / 1000; }
json maybe(const std::optional<double>& value) { return value ? json(*value) : json(nullptr); }

/// `from` and `to` of the query; the last day unless told.
fleet::Span span_of(const Call& call) {
  const auto now = db::now_ms();
  fleet::Span span;
  span.to_ms = time_of(call, "to").value_or(now);
  span.from_ms = time_of(call, "from").value_or(span.to_ms - db::kDayMs);
  return span;
}

std::int64_t body_time(const Call& call, const char* name) {
  const auto time = parse_time(call.body_text(name));
  if (!time) throw Refused("bad_request", name);
  return *time;
}

fleet::OeeBy by_of(const Call& call) {
  const auto by = call.text("by", "machine");
  if (by == "machine") return fleet::OeeBy::machine;
  if (by == "day") return fleet::OeeBy::day;
  if (by == "week") return fleet::OeeBy::week;
  if (by == "shift") return fleet::OeeBy::shift;
  throw Refused("bad_request", "by");
}

json clock_json(int minute) {
  const auto two = [](int n) { return std::string(n < 10 ? "0" : "") + std::to_string(n); };
  return two(minute / 60) + ":" + two(minute % 60);
}

/// "06:30" → 390. Throws Refused("bad_request").
int clock_of(const json& text, const char* name) {
  const auto clock = text.is_string() ? text.get<std::string>() : std::string();
  const auto digit = [&](std::size_t at) { return clock[at] >= '0' && clock[at] <= '9' ? clock[at] - '0' : 99; };
  if (clock.size() != 5 || clock[2] != ':') throw Refused("bad_request", name);
  const int hour = digit(0) * 10 + digit(1), minute = digit(3) * 10 + digit(4);
  if (hour > 23 || minute > 59) throw Refused("bad_request", name);
  return hour * 60 + minute;
}

json shape(const fleet::Calendar& calendar) {
  json shifts = json::array();
  for (const auto& shift : calendar.shifts) {
    json days = json::array();
    for (int day = 0; day < 7; ++day)
      if ((shift.days >> day & 1) != 0) days.push_back(day + 1);
    shifts.push_back({{"name", shift.name},
                      {"days", std::move(days)},
                      {"start", clock_json(shift.start_minute)},
                      {"end", clock_json(shift.end_minute)}});
  }
  return {{"time_zone", calendar.time_zone}, {"shifts", std::move(shifts)}};
}

fleet::Calendar calendar_of(const Call& call) {
  fleet::Calendar calendar;
  calendar.time_zone = call.body_text("time_zone");
  const auto shifts = call.body.find("shifts");
  if (shifts == call.body.end() || !shifts->is_array()) throw Refused("bad_request", "shifts");
  for (const json& given : *shifts) {
    if (!given.is_object()) throw Refused("bad_request", "shifts");
    fleet::Shift shift;
    const auto name = given.find("name");
    if (name == given.end() || !name->is_string()) throw Refused("bad_request", "name");
    shift.name = name->get<std::string>();
    shift.start_minute = clock_of(given.value("start", json()), "start");
    shift.end_minute = clock_of(given.value("end", json()), "end");
    const auto days = given.find("days");
    if (days == given.end() || !days->is_array()) throw Refused("bad_request", "days");
    for (const json& day : *days) {
      const int number = day.is_number_integer() ? day.get<int>() : 0;
      if (number < 1 || number > 7) throw Refused("bad_request", "days");
      shift.days = static_cast<std::uint8_t>(shift.days | 1 << (number - 1));
    }
    calendar.shifts.push_back(std::move(shift));
  }
  return calendar;
}

json shape(const fleet::DowntimeReason& reason) {
  return {{"id", reason.id}, {"name", {{"en", reason.name_en}, {"zh", reason.name_zh}}}, {"planned", reason.planned}};
}

json shape(const fleet::DowntimeNote& note) {
  return {{"id", note.id},          {"machine", note.machine},
          {"from", time_json(note.from_ms)}, {"to", time_json(note.to_ms)},
          {"reason", note.reason ? json(*note.reason) : json(nullptr)}, {"note", note.note},
          {"by", note.by_user},     {"at", time_json(note.at_ms)}};
}

json shape(const fleet::Reject& reject) {
  return {{"id", reject.id},           {"machine", reject.machine}, {"at", time_json(reject.at_ms)},
          {"program", reject.program}, {"quantity", reject.quantity}, {"why", reject.why},
          {"by", reject.by_user},      {"entered", time_json(reject.entered_ms)}};
}

json shape(const fleet::Stop& stop) {
  return {{"from", time_json(stop.from_ms)}, {"to", time_json(stop.to_ms)}, {"state", stop.state},
          {"open", stop.open},               {"note", stop.note ? shape(*stop.note) : json(nullptr)}};
}

json shape(const fleet::OeeRow& row) {
  const auto& figures = row.figures;
  json states = json::object(), reasons = json::array();
  for (std::size_t i = 0; i < fleet::kStates.size(); ++i)
    states[std::string(fleet::kStates[i])] = as_seconds(figures.in_state_ms[i]);
  for (const auto& [reason, ms] : figures.by_reason_ms) reasons.push_back({{"reason", reason}, {"s", as_seconds(ms)}});
  return {{"machine", row.machine},
          {"from", time_json(row.span.from_ms)},
          {"to", time_json(row.span.to_ms)},
          {"day", row.day.empty() ? json(nullptr) : json(row.day)},
          {"shift", row.shift.empty() ? json(nullptr) : json(row.shift)},
          {"availability", maybe(figures.availability())},
          {"performance", maybe(figures.performance())},
          {"quality", maybe(figures.quality())},
          {"oee", maybe(figures.oee())},
          {"scheduled_s", as_seconds(figures.scheduled_ms)},
          {"planned_s", as_seconds(figures.planned_ms())},
          {"planned_stop_s", as_seconds(figures.planned_stop_ms)},
          {"unknown_s", as_seconds(figures.unknown_ms())},
          {"unexplained_s", as_seconds(figures.unexplained_ms)},
          {"states", std::move(states)},
          {"reasons", std::move(reasons)},
          {"parts", figures.parts},
          {"rejects", figures.rejects},
          {"ideal_s", figures.ideal_ms / 1000},
          {"parts_without_ideal", figures.parts_without_ideal}};
}

json shape(const fleet::AlarmFigures& alarm) {
  return {{"code", alarm.code},
          {"text", {{"en", alarm.text_en}, {"zh", alarm.text_zh}}},
          {"count", alarm.count},
          {"active_s", as_seconds(alarm.active_ms)},
          {"machines", alarm.machines},
          {"last", time_json(alarm.last_ms)}};
}

template <class Rows>
Reply rows_reply(const Rows& rows) {
  json items = json::array();
  for (const auto& row : rows) items.push_back(shape(row));
  return json_reply({{"items", std::move(items)}, {"next", nullptr}});
}

const Query only_machine = {"machine", "integer", "only this machine"};

std::vector<Route> figures(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/oee", .role = Role::viewer,
                    .summary = "Availability, performance, quality, and what was counted for them",
                    .response = "OeeRows",
                    .query = with({only_machine, {"by", "string", "machine, day, week or shift"}}, period),
                    .errors = {"bad_value"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.number("machine", 0);
                      const auto span = span_of(call);
                      const auto by = by_of(call);
                      const auto rows = co_await s.store.run(
                          [=](db::Database& db) { return fleet::oee(db, machine, span, by, db::now_ms()); });
                      co_return rows_reply(rows);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/alarms/statistics", .role = Role::viewer,
                    .summary = "How often and how long each alarm was there, most time first",
                    .response = "AlarmFigures", .query = with({only_machine}, period),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.number("machine", 0);
                      const auto span = span_of(call);
                      const auto rows = co_await s.store.run([=](db::Database& db) {
                        return fleet::alarm_figures(db, machine, span, db::now_ms());
                      });
                      co_return rows_reply(rows);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/stops", .role = Role::viewer,
                    .summary = "Stretches without running, with the reason somebody gave", .response = "Stops",
                    .query = with({{"shortest", "integer", "seconds; 60 unless told"}}, period),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.id("id");
                      const auto span = span_of(call);
                      const auto shortest_ms = std::clamp<std::int64_t>(call.number("shortest", 60), 0, 86'400) * 1000;
                      const auto rows = co_await s.store.run([=](db::Database& db) {
                        fleet::require_machine(db, machine);
                        return fleet::stops(db, machine, span, shortest_ms, db::now_ms());
                      });
                      co_return rows_reply(rows);
                    }});
  return routes;
}

std::vector<Route> entries(Services& s) {
  std::vector<Route> routes;
  routes.push_back(
      {.method = Method::post, .pattern = "/machines/{id}/downtime", .role = needs(Action::note_downtime),
       .summary = "Enter why the machine stood; a newer entry counts over an older one, `reason` null takes it back",
       .takes = Takes::json, .request = "NewDowntime", .response = "DowntimeNote", .status = 201,
       .errors = {"bad_value", "in_the_future", "not_found"}, .handler = [&s](Call& call) -> awaitable<Reply> {
         fleet::DowntimeNote note;
         note.machine = call.id("id");
         note.from_ms = body_time(call, "from");
         note.to_ms = body_time(call, "to");
         if (!call.body.contains("reason")) throw Refused("bad_request", "reason");
         if (!call.body.at("reason").is_null()) note.reason = call.body_number("reason");
         note.note = call.body_text("note", "");
         const auto actor = actor_of(call);
         const auto kept = co_await s.store.run(
             [&](db::Database& db) { return fleet::note_downtime(db, actor, note, db::now_ms()); });
         co_return json_reply(shape(kept), 201);
       }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/downtime", .role = Role::viewer,
                    .summary = "All entries of that time, oldest entry first", .response = "DowntimeNotes",
                    .query = period, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.id("id");
                      const auto span = span_of(call);
                      const auto rows = co_await s.store.run([=](db::Database& db) {
                        fleet::require_machine(db, machine);
                        return fleet::downtime_notes(db, machine, span);
                      });
                      co_return rows_reply(rows);
                    }});
  routes.push_back(
      {.method = Method::post, .pattern = "/machines/{id}/rejects", .role = needs(Action::note_downtime),
       .summary = "Enter rejected parts; a negative quantity takes an entry back", .takes = Takes::json,
       .request = "NewReject", .response = "Reject", .status = 201,
       .errors = {"bad_value", "in_the_future", "reason_missing"}, .handler = [&s](Call& call) -> awaitable<Reply> {
         fleet::Reject reject;
         reject.machine = call.id("id");
         reject.at_ms = call.body.contains("at") ? body_time(call, "at") : db::now_ms();
         reject.program = call.body_text("program", "");
         reject.quantity = call.body_number("quantity");
         reject.why = call.body_text("why");
         const auto actor = actor_of(call);
         const auto kept = co_await s.store.run(
             [&](db::Database& db) { return fleet::note_reject(db, actor, reject, db::now_ms()); });
         co_return json_reply(shape(kept), 201);
       }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/rejects", .role = Role::viewer,
                    .summary = "Rejected parts of that time", .response = "Rejects", .query = period,
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.id("id");
                      const auto span = span_of(call);
                      const auto rows = co_await s.store.run([=](db::Database& db) {
                        fleet::require_machine(db, machine);
                        return fleet::rejects(db, machine, span);
                      });
                      co_return rows_reply(rows);
                    }});
  return routes;
}

std::vector<Route> settings(Services& s) {
  const Need role = needs(Action::edit_calendar);
  const auto reason_of = [](const Call& call) {
    fleet::DowntimeReason reason;
    reason.name_en = call.body_text("name_en");
    reason.name_zh = call.body_text("name_zh");
    reason.planned = call.body.contains("planned") && call.body.at("planned") == json(true);
    return reason;
  };
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/calendar", .role = Role::viewer,
                    .summary = "The shop's time zone and shifts", .response = "Calendar",
                    .handler = [&s](Call&) -> awaitable<Reply> {
                      co_return json_reply(
                          shape(co_await s.store.run([](db::Database& db) { return fleet::read_calendar(db); })));
                    }});
  routes.push_back({.method = Method::patch, .pattern = "/calendar", .role = role,
                    .summary = "Replace time zone and shifts", .takes = Takes::json, .request = "Calendar",
                    .response = "Calendar", .errors = {"bad_value", "shifts_overlap"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto calendar = calendar_of(call);
                      const auto actor = actor_of(call);
                      const auto kept = co_await s.store.run([&](db::Database& db) {
                        fleet::write_calendar(db, actor, calendar);
                        return fleet::read_calendar(db);
                      });
                      co_return json_reply(shape(kept));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/downtime-reasons", .role = Role::viewer,
                    .summary = "Why machines stand: what can be chosen", .response = "DowntimeReasons",
                    .handler = [&s](Call&) -> awaitable<Reply> {
                      co_return rows_reply(
                          co_await s.store.run([](db::Database& db) { return fleet::downtime_reasons(db); }));
                    }});
  routes.push_back({.method = Method::post, .pattern = "/downtime-reasons", .role = role,
                    .summary = "Add a reason", .takes = Takes::json, .request = "NewDowntimeReason",
                    .response = "DowntimeReason", .status = 201, .errors = {"bad_value"},
                    .handler = [&s, reason_of](Call& call) -> awaitable<Reply> {
                      const auto reason = reason_of(call);
                      const auto actor = actor_of(call);
                      const auto kept = co_await s.store.run(
                          [&](db::Database& db) { return fleet::put_downtime_reason(db, actor, reason); });
                      co_return json_reply(shape(kept), 201);
                    }});
  routes.push_back({.method = Method::patch, .pattern = "/downtime-reasons/{id}", .role = role,
                    .summary = "Change a reason", .takes = Takes::json, .request = "NewDowntimeReason",
                    .response = "DowntimeReason", .errors = {"bad_value"},
                    .handler = [&s, reason_of](Call& call) -> awaitable<Reply> {
                      auto reason = reason_of(call);
                      reason.id = call.id("id");
                      const auto actor = actor_of(call);
                      const auto kept = co_await s.store.run(
                          [&](db::Database& db) { return fleet::put_downtime_reason(db, actor, reason); });
                      co_return json_reply(shape(kept));
                    }});
  routes.push_back({.method = Method::del, .pattern = "/downtime-reasons/{id}", .role = role,
                    .summary = "Remove a reason; what was entered with it keeps it", .status = 204,
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto actor = actor_of(call);
                      co_await s.store.run([&](db::Database& db) {
                        fleet::remove_downtime_reason(db, actor, id, db::now_ms());
                      });
                      co_return empty_reply();
                    }});
  return routes;
}

}  // namespace

std::vector<Route> accounting_routes(Services& s) {
  auto routes = figures(s);
  for (auto& more : {entries(s), settings(s)}) routes.insert(routes.end(), more.begin(), more.end());
  return routes;
}

}  // namespace headstock::api
