#include "server/fleet/value_requests.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "interpreter/data_values.hpp"
#include "server/access/audit.hpp"
#include "server/fleet/values.hpp"
#include "server/fleet/writing_order.hpp"

namespace headstock::fleet {
namespace {

namespace asio = boost::asio;
using access::Action;
using access::Actor;
using nlohmann::json;

constexpr std::size_t kMostItems = 8'000;  // of one request: two pages of 400 numbers; fits one message
constexpr std::array<std::string_view, 5> kOrigins = {"person", "import", "copy", "restore", "compensation"};
constexpr std::array<std::string_view, 7> kLimitKinds = {"wear",     "geometry",  "radius",   "work",
                                                         "variable", "parameter", "tool_life"};
/// Reasons after which the machine may or may not have it.
constexpr std::array<std::string_view, 2> kUnsure = {"timeout", "link_lost"};

db::ValueRequestRow require_request(db::Database& db, std::int64_t id) {
  auto row = db::value_request(db, id);
  if (!row) throw db::Refusal("not_found", access::subject("request", id));
  return *row;
}

db::ValueRequestRow require_waiting(db::Database& db, std::int64_t id) {
  db::ValueRequestRow row = require_request(db, id);
  if (row.state != "waiting") throw db::Refusal("already_decided", access::subject("request", id));
  return row;
}

/// A whole group of tool life goes with its life, what is known of a tool with the tool.
bool is_taken_off_by_itself(std::string_view what, const db::MachineValues& wanted) {
  const LifePlace place = life_place(what);
  if (place.group == 0) return true;
  const bool group_stays = wanted.contains("tool_life/" + std::to_string(place.group) + "/life");
  return group_stays ? place.field == "tool" : place.field == "life";
}

/// What nobody has entered of a group or a tool that stays is 0, told only by the machine's next report: a set from before it
/// does not name it.
bool is_unnamed_zero(std::string_view what, const db::MachineValues& wanted) {
  const LifePlace place = life_place(what);
  const std::string group = "tool_life/" + std::to_string(place.group);
  return place.group != 0 && wanted.contains(group + "/life") &&
         (place.index < 0 || wanted.contains(group + "/tool/" + std::to_string(place.index)));
}

}  // namespace

db::ValueRequestRow ask_values(db::Database& db, const Actor& actor, const NewValueRequest& asked,
                               std::int64_t now_ms) {
  demand(actor, Action::edit_offsets);
  if (asked.items.empty() || asked.items.size() > kMostItems) throw db::Refusal("no_values");
  if (std::ranges::find(kOrigins, asked.origin) == kOrigins.end()) throw db::Refusal("bad_value", "origin");
  db::Transaction transaction(db);
  MachinePages pages = machine_pages(db, asked.machine);
  if (!pages.machine.offsets_at_ms) throw db::Refusal("machine_not_read", pages.machine.name);
  const interp::MachineData now = pages.data;
  const auto limits = db::value_limits(db, asked.machine);
  db::ValueRequestRow row;
  for (const db::ValueItem& item : asked.items) {
    const interp::ValueRead read = interp::read_value(now, pages.axes, item.what);
    if (!read.known) throw db::Refusal("value_refused", item.what.substr(0, 80) + ": bad_place");
    if (!same_as_shown(read.value, item.before)) throw db::Refusal("changed_meanwhile", item.what);
    const std::string why =
        dialects::refuse_value(*pages.dialect, pages.data, pages.axes, item.what, item.after, kAnyTime);
    if (!why.empty()) throw db::Refusal("value_refused", item.what + ": " + why);
    if (!interp::write_value(pages.data, pages.axes, item.what, item.after, pages.page.numbers))
      throw db::Refusal("value_refused", item.what + ": out_of_range");
    const auto limit = limits.find(limit_kind(item.what));
    if (limit != limits.end() && row.needs_second.empty() &&
        std::fabs(item.after.value_or(0) - item.before.value_or(0)) > limit->second + 1e-9)
      row.needs_second = item.what;
    if (!same_as_shown(item.before, item.after)) row.items.push_back(item);
  }
  if (row.items.empty()) throw db::Refusal("no_values");
  row.machine = asked.machine;
  row.by = actor.user;
  row.at_ms = now_ms;
  row.origin = asked.origin;
  row.why = asked.why.substr(0, 500);
  row.state = row.needs_second.empty() ? "sending" : "waiting";
  row.id = db::insert_value_request(db, row);
  access::record(db, actor, "values.ask", access::subject("machine", row.machine),
                 {{"request", std::to_string(row.id)},
                  {"origin", row.origin},
                  {"values", std::to_string(row.items.size())},
                  {"first", row.items.front().what},
                  {"state", row.state}});
  transaction.commit();
  return row;
}

db::ValueRequestRow agree(db::Database& db, const Actor& actor, std::int64_t id, std::int64_t now_ms) {
  demand(actor, Action::edit_offsets);
  db::Transaction transaction(db);
  db::ValueRequestRow row = require_waiting(db, id);
  if (row.by == actor.user) throw db::Refusal("same_person", row.by);
  row.state = "sending";
  row.second = actor.user;
  row.second_ms = now_ms;
  db::update_value_request(db, row);
  access::record(db, actor, "values.agree", access::subject("machine", row.machine),
                 {{"request", std::to_string(id)}});
  transaction.commit();
  return row;
}

db::ValueRequestRow withdraw(db::Database& db, const Actor& actor, std::int64_t id, std::int64_t now_ms) {
  demand(actor, Action::edit_offsets);
  db::Transaction transaction(db);
  db::ValueRequestRow row = require_waiting(db, id);
  row.state = "withdrawn";
  row.second = actor.user;
  row.ended_ms = now_ms;
  db::update_value_request(db, row);
  access::record(db, actor, "values.withdraw", access::subject("machine", row.machine),
                 {{"request", std::to_string(id)}});
  transaction.commit();
  return row;
}

db::ValueRequestRow finish_request(db::Database& db, std::int64_t id, const json& answer,
                                   std::int64_t now_ms) {
  db::Transaction transaction(db);
  db::ValueRequestRow row = require_request(db, id);
  if (row.state != "sending" && row.state != "unknown") return row;  // its events told it first
  row.reason = answer.value("reason", "");
  row.where = answer.value("where", "").substr(0, 80);
  const json values = answer.value("values", json::object());
  bool agrees = true;
  for (db::ValueItem& item : row.items) {
    const auto read = values.find(item.what);
    if (read == values.end()) continue;
    item.was_read = true;
    item.read_back = read->is_number() ? std::optional(read->get<double>()) : std::nullopt;
    agrees &= same_as_shown(item.read_back, item.after);
  }
  const bool all_read = std::ranges::all_of(row.items, &db::ValueItem::was_read);
  // Another change (a G10, a measurement) was on the disk behind this one before it was read: both are in the
  // history.
  agrees |= answer.value("overtaken", false);
  if (answer.value("accepted", false)) {
    // Done is what was read back from the machine's disk, nothing less.
    row.state = agrees && all_read ? "done" : "failed";
    if (row.state == "failed") row.reason = "read_back_differs";
  } else if (std::ranges::find(kUnsure, row.reason) != kUnsure.end()) {
    row.state = "unknown";
  } else {
    row.state = row.reason == "not_connected" ? "failed" : "refused";
  }
  if (row.state != "unknown") row.ended_ms = now_ms;
  db::update_value_request(db, row);
  transaction.commit();
  return row;
}

std::vector<std::int64_t> settle_unknown(db::Database& db, std::int64_t machine, std::int64_t now_ms) {
  db::Transaction transaction(db);
  std::vector<std::int64_t> ended;
  const db::MachineValues now = db::machine_values(db, machine);
  for (db::ValueRequestRow& row : db::value_requests(db, {machine, "unknown", false}, {0, 1000}).items) {
    const bool carried_out = db::request_was_carried_out(db, row.id);
    row.state = carried_out ? "done" : "failed";
    row.reason = carried_out ? "" : "not_carried_out";
    row.ended_ms = now_ms;
    if (carried_out)
      for (db::ValueItem& item : row.items) {
        const auto found = now.find(item.what);
        item.was_read = true;
        item.read_back = found != now.end()  ? std::optional(found->second)
                         : item.after == 0.0 ? std::optional(0.0)
                                             : std::nullopt;
      }
    db::update_value_request(db, row);
    ended.push_back(row.id);
  }
  transaction.commit();
  return ended;
}

void unsettle_after_restart(db::Database& db) {
  db.execute(
      "UPDATE value_requests SET state = 'unknown', reason = 'server_restarted' WHERE state = 'sending'");
}

void set_value_limit(db::Database& db, const Actor& actor, std::int64_t machine, const std::string& kind,
                     std::optional<double> step) {
  demand(actor, Action::edit_offsets);
  if (std::ranges::find(kLimitKinds, kind) == kLimitKinds.end()) throw db::Refusal("bad_value", "kind");
  if (step && !(*step >= 0 && *step <= 1e6)) throw db::Refusal("bad_value", "step");
  db::Transaction transaction(db);
  db::put_value_limit(db, machine, kind, step);
  access::record(db, actor, "values.limit", access::subject("machine", machine),
                 {{"kind", kind}, {"step", step ? std::to_string(*step) : std::string("none")}});
  transaction.commit();
}

db::SnapshotRow take_snapshot(db::Database& db, const Actor& actor, std::int64_t machine,
                              const std::string& name, std::int64_t now_ms) {
  demand(actor, Action::edit_offsets);
  if (name.empty() || name.size() > 200) throw db::Refusal("bad_name", name.substr(0, 60));
  db::Transaction transaction(db);
  const MachinePages pages = machine_pages(db, machine);
  if (!pages.machine.offsets_at_ms) throw db::Refusal("machine_not_read", pages.machine.name);
  db::SnapshotRow row;
  row.machine = machine;
  row.profile = pages.machine.profile;
  row.name = name;
  row.by = actor.user;
  row.at_ms = now_ms;
  const db::MachineValues values = db::machine_values(db, machine);
  row.values = static_cast<std::int64_t>(values.size());
  row.id = db::insert_snapshot(db, row, values);
  access::record(db, actor, "values.snapshot", access::subject("machine", machine),
                 {{"snapshot", std::to_string(row.id)}, {"name", name}});
  transaction.commit();
  return row;
}

Difference difference(db::Database& db, std::int64_t machine, const db::MachineValues& wanted,
                      const std::string& kind) {
  const MachinePages pages = machine_pages(db, machine);
  Difference result;
  const auto consider = [&](const std::string& what, std::optional<double> after) {
    if (!in_kind(kind, what)) return;
    if (what == "tool_life/change_due" || what == "tool_life/notice_group" || what.ends_with("/registered"))
      return;
    const interp::ValueRead read = interp::read_value(pages.data, pages.axes, what);
    const auto place = dialects::refuse_value(*pages.dialect, pages.data, pages.axes, what,
                                              after ? after : read.value, kAnyTime);
    if (!read.known || place == "bad_place") {
      result.without_place += after && *after != 0;
      return;
    }
    if (!after && (what.starts_with("tool/") || what.starts_with("work/"))) after = 0;
    if (!same_as_shown(read.value, after))
      result.items.push_back({what, read.value, after, std::nullopt, false});
  };
  for (const auto& [what, value] : wanted) consider(what, value);
  for (const auto& [what, value] : db::machine_values(db, machine)) {
    if (wanted.contains(what)) continue;
    if (is_taken_off_by_itself(what, wanted)) consider(what, std::nullopt);
    else if (is_unnamed_zero(what, wanted)) consider(what, 0);
  }
  put_in_writing_order(result.items);
  return result;
}

asio::awaitable<db::ValueRequestRow> ValueDesk::ask(Actor actor, NewValueRequest request) {
  const auto in_store = [&](db::Database& db) { return ask_values(db, actor, request, db::now_ms()); };
  co_return co_await carry_out(co_await store_.run(in_store));
}

asio::awaitable<db::ValueRequestRow> ValueDesk::carry_out(db::ValueRequestRow row) {
  if (row.state == "sending") co_return co_await send(std::move(row));
  changed_(row.machine);
  co_return row;
}

asio::awaitable<db::ValueRequestRow> ValueDesk::agree(Actor actor, std::int64_t id) {
  const auto in_store = [&](db::Database& db) { return fleet::agree(db, actor, id, db::now_ms()); };
  db::ValueRequestRow row = co_await store_.run(in_store);
  co_return co_await send(std::move(row));
}

asio::awaitable<db::ValueRequestRow> ValueDesk::send(db::ValueRequestRow row) {
  const auto number = [](const std::optional<double>& value) { return value ? json(*value) : json(nullptr); };
  json values = json::array();
  for (const db::ValueItem& item : row.items)
    values.push_back({{"what", item.what}, {"before", number(item.before)}, {"after", number(item.after)}});
  json write = {{"request", static_cast<std::uint64_t>(row.id)},
                {"origin", row.origin},
                {"by", row.by},
                {"values", std::move(values)}};
  const json answer = co_await carry_(row.machine, std::move(write));
  const auto in_store = [&](db::Database& db) { return finish_request(db, row.id, answer, db::now_ms()); };
  row = co_await store_.run(in_store);
  changed_(row.machine);
  co_return row;
}

}  // namespace headstock::fleet
