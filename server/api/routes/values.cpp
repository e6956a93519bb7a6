// Offsets, tool life, parameters and variables of the machines.
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "dialects/catalogue.hpp"
#include "protocol/wire/reasons.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/routes/value_shapes.hpp"
#include "server/fleet/fleet.hpp"
#include "server/fleet/machines.hpp"
#include "server/fleet/value_requests.hpp"
#include "server/fleet/values.hpp"

namespace headstock::api {

namespace {

using access::Action;
using boost::asio::awaitable;

const Query kind_query = {"kind", "string", "offsets, work, parameters, variables or tool_life; all unless told"};

std::string kind_of(const Call& call) {
  const std::string kind = call.text("kind");
  for (const char* known : {"", "offsets", "work", "parameters", "variables", "tool_life"})
    if (kind == known) return kind;
  throw Refused("bad_request", "kind");
}

std::optional<double> member_or_null(const json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || found->is_null()) return std::nullopt;
  if (!found->is_number()) throw Refused("bad_request", key);
  return found->get<double>();
}

/// Done, waiting and not yet known are answers; what the machine refused is a 409 with its reason in words.
Reply request_reply(const db::ValueRequestRow& row) {
  json body = to_json(row);
  if (row.state != "refused" && row.state != "failed") return json_reply(body);
  const auto text = protocol::reason_text(row.reason);
  return json_reply({{"accepted", false},
                     {"reason", row.reason},
                     {"request", std::move(body)},
                     {"error",
                      {{"code", "machine_refused"},
                       {"message", {{"en", text.en}, {"zh", text.zh}}},
                       {"where", row.where.empty() ? json(row.reason) : json(row.where)}}}},
                    409);
}

json values_json(Services& s, const fleet::MachinePages& pages, const db::MachineValues& values,
                 const std::string& kind) {
  json items = json::object();
  for (const auto& [what, value] : values)
    if (fleet::in_kind(kind, what)) items[what] = value;
  return {{"machine", pages.machine.id},
          {"profile", pages.machine.profile},
          {"values", std::move(items)},
          {"page", to_json(pages.page, pages.axes)},
          {"version", pages.machine.offsets_version},
          {"reported", time_json(pages.machine.offsets_at_ms)},
          {"parameter_write", s.fleet.parameter_write(pages.machine.id)}};
}

std::vector<Route> reading_values(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/values", .role = Role::viewer,
                    .summary = "Offsets, tool life, parameters and variables the machine has, by name; what is not in it is 0 or not set",
                    .response = "MachineValues", .query = {kind_query}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto kind = kind_of(call);
                      fleet::MachinePages pages;
                      const auto values = co_await s.store.run([&pages, id](db::Database& db) {
                        pages = fleet::machine_pages(db, id);
                        return db::machine_values(db, id);
                      });
                      co_return json_reply(values_json(s, pages, values, kind));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/values/sheet", .role = Role::viewer,
                    .summary = "The same as CSV", .response = "bytes", .query = {kind_query},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto kind = kind_of(call);
                      Reply reply;
                      reply.content_type = "text/csv; charset=utf-8";
                      reply.headers.emplace_back("Content-Disposition",
                                                 "attachment; filename=\"machine-" + std::to_string(id) + "-" +
                                                     (kind.empty() ? "values" : kind) + ".csv\"");
                      const auto in_store = [&kind, id](db::Database& db) {
                        return fleet::write_sheet(fleet::machine_pages(db, id), db::machine_values(db, id), kind);
                      };
                      reply.body = co_await s.store.run(in_store);
                      co_return reply;
                    }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/value-changes", .role = Role::viewer,
                    .summary = "Every change with who and what, before and after, newest first", .response = "ValueChanges",
                    .query = with(with({{"what", "string", "exactly, or all that begin so when it ends in /"}}, period), paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      db::ValueChangeFilter filter;
                      filter.machine = call.id("id");
                      filter.what = call.text("what");
                      filter.from_ms = time_of(call, "from");
                      filter.to_ms = time_of(call, "to");
                      const auto page = page_of(call);
                      const auto in_store = [&](db::Database& db) {
                        fleet::require_machine(db, filter.machine);
                        return db::value_changes(db, filter, page);
                      };
                      const auto list = co_await s.store.run(in_store);
                      co_return json_reply(list_json(list));
                    }});
  routes.push_back(
      {.method = Method::get, .pattern = "/machines/{id}/values/difference", .role = Role::viewer,
       .summary = "What would be written to make this machine's values those of another machine, a moment or a snapshot",
       .response = "ValueDifference",
       .query = {kind_query, {"machine", "integer", "the other machine"}, {"at", "string", "a moment"}, {"snapshot", "integer", "a snapshot"}},
       .errors = {"other_profile", "machine_not_read"}, .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto id = call.id("id"), other = call.number("machine", 0), snapshot = call.number("snapshot", 0);
         const auto at = time_of(call, "at");
         const auto kind = kind_of(call);
         if ((other != 0) + (snapshot != 0) + at.has_value() != 1) throw Refused("bad_request", "machine, at or snapshot");
         const auto in_store = [&](db::Database& db) {
           const auto mine = fleet::require_machine(db, id);
           if (!mine.offsets_at_ms) throw db::Refusal("machine_not_read", mine.name);
           db::MachineValues wanted;
           std::string profile = mine.profile;
           if (other != 0) {
             const auto row = fleet::require_machine(db, other);
             if (!row.offsets_at_ms) throw db::Refusal("machine_not_read", row.name);
             profile = row.profile;
             wanted = db::machine_values(db, other);
           } else if (snapshot != 0) {
             const auto row = db::snapshot(db, snapshot);
             if (!row) throw db::Refusal("not_found", "snapshot:" + std::to_string(snapshot));
             profile = row->profile;
             wanted = db::snapshot_values(db, snapshot);
           } else {
             wanted = db::machine_values(db, id, at);
           }
           // Offsets mean the same on two lathes of different make; parameters do not.
           const bool portable = kind == "offsets" || kind == "work";
           if (profile != mine.profile && !portable) throw db::Refusal("other_profile", profile);
           return fleet::difference(db, id, wanted, kind);
         };
         const auto difference = co_await s.store.run(in_store);
         json answer = list_json(difference.items);
         answer["without_place"] = difference.without_place;
         co_return json_reply(answer);
       }});
  routes.push_back(
      {.method = Method::get, .pattern = "/machines/{id}/parameters", .role = Role::viewer,
       .summary = "The manual's parameter table with the values the machine has", .response = "Parameters",
       .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto id = call.id("id");
         fleet::MachinePages pages;
         const auto values = co_await s.store.run([&pages, id](db::Database& db) {
           pages = fleet::machine_pages(db, id);
           return db::machine_values(db, id);
         });
         const std::string series = pages.page.lathe ? "T" : "M";
         std::map<std::string, json> set;
         for (const auto& [what, value] : values) {
           if (!what.starts_with("parameter/")) continue;
           const auto key = what.substr(10);
           const auto slash = key.find('/');
           if (slash == key.npos)
             set[key]["value"] = value;
           else
             set[key.substr(0, slash)]["axes"][key.substr(slash + 1)] = value;
         }
         json items = json::array();
         for (const auto& row : dialects::parameters(pages.machine.profile)) {
           if (!row.series.empty() && row.series.find(series) == row.series.npos) continue;
           const std::string number(row.number);
           const auto found = set.find(number);
           items.push_back({{"number", number},
                            {"symbol", row.symbol},
                            {"name_zh", row.name_zh},
                            {"meaning", row.meaning},
                            {"unit", row.unit},
                            {"range", row.range},
                            {"default", row.default_value},
                            {"effective", row.effective},
                            {"value", found != set.end() && found->second.contains("value") ? found->second["value"] : json(nullptr)},
                            {"axes", found != set.end() && found->second.contains("axes") ? found->second["axes"] : json(nullptr)}});
           if (found != set.end()) set.erase(found);
         }
         for (const auto& [number, value] : set)
           items.push_back({{"number", number}, {"symbol", ""}, {"name_zh", ""}, {"meaning", ""}, {"unit", ""}, {"range", ""},
                            {"default", ""}, {"effective", ""}, {"value", value.value("value", json())}, {"axes", value.value("axes", json())}});
         co_return json_reply({{"items", std::move(items)},
                               {"next", nullptr},
                               {"profile", pages.machine.profile},
                               {"parameter_write", s.fleet.parameter_write(id)}});
       }});
  return routes;
}

std::vector<Route> writing(Services& s) {
  std::vector<Route> routes;
  routes.push_back(
      {.method = Method::post, .pattern = "/machines/{id}/values", .role = needs(Action::edit_offsets),
       .summary = "Write values: all or none, each with the value that was seen; done when read back from the machine. Above a limit it waits for a second person",
       .takes = Takes::json, .request = "NewValueRequest", .response = "ValueRequest",
       .errors = {"changed_meanwhile", "value_refused", "no_values", "machine_not_read", "machine_refused"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         fleet::NewValueRequest request;
         request.machine = call.id("id");
         request.origin = call.body_text("origin", "person");
         request.why = call.body_text("why", "");
         const auto values = call.body.find("values");
         if (values == call.body.end() || !values->is_array()) throw Refused("bad_request", "values");
         for (const json& one : *values) {
           if (!one.is_object() || !one.contains("what") || !one["what"].is_string()) throw Refused("bad_request", "values");
           request.items.push_back({one["what"].get<std::string>(), member_or_null(one, "before"), member_or_null(one, "after"), std::nullopt, false});
         }
         const auto row = co_await s.values.ask(actor_of(call), std::move(request));
         co_return request_reply(row);
       }});
  routes.push_back({.method = Method::post, .pattern = "/machines/{id}/values/sheet", .role = Role::viewer,
                    .summary = "Read a pasted or imported table: what would be written, and what is wrong. Nothing is changed",
                    .takes = Takes::json, .request = "SheetText", .response = "Sheet",
                    .errors = {"bad_sheet", "other_profile", "other_unit", "too_large"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto text = call.body_text("text");
                      const auto in_store = [id](db::Database& db) { return fleet::machine_pages(db, id); };
                      const auto pages = co_await s.store.run(in_store);
                      const auto sheet = fleet::read_sheet(pages, text);
                      json answer = list_json(sheet.rows);
                      answer["values"] = sheet.values;
                      co_return json_reply(answer);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/value-requests", .role = Role::viewer,
                    .summary = "What was asked to be written, and what became of it", .response = "ValueRequests",
                    .query = with({{"machine", "integer", "only this machine"}, {"state", "string", "exactly"}, {"open", "boolean", "only those not ended"}}, paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      db::ValueRequestFilter filter;
                      filter.machine = call.number("machine", 0);
                      filter.state = call.text("state");
                      const auto open = call.text("open");
                      filter.open_only = open == "true" || open == "1";
                      const auto page = page_of(call);
                      const auto in_store = [&](db::Database& db) { return db::value_requests(db, filter, page); };
                      const auto list = co_await s.store.run(in_store);
                      co_return json_reply(list_json(list));
                    }});
  routes.push_back({.method = Method::post, .pattern = "/value-requests/{id}/agree", .role = needs(Action::edit_offsets),
                    .summary = "The second person agrees: it is written now", .takes = Takes::json, .response = "ValueRequest",
                    .errors = {"already_decided", "same_person", "machine_refused"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await s.values.agree(actor_of(call), call.id("id"));
                      co_return request_reply(row);
                    }});
  routes.push_back({.method = Method::post, .pattern = "/value-requests/{id}/withdraw", .role = needs(Action::edit_offsets),
                    .summary = "It is not written", .takes = Takes::json, .response = "ValueRequest", .errors = {"already_decided"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto id = call.id("id");
                      const auto in_store = [&](db::Database& db) { return fleet::withdraw(db, actor, id, db::now_ms()); };
                      const auto row = co_await s.store.run(in_store);
                      s.fleet.values_changed(row.machine);
                      co_return json_reply(to_json(row));
                    }});
  return routes;
}

awaitable<Reply> limits_of(Services& s, std::int64_t machine) {
  const auto in_store = [machine](db::Database& db) {
    if (machine != 0) fleet::require_machine(db, machine);
    return db::value_limits(db, machine);
  };
  const auto limits = co_await s.store.run(in_store);
  json answer = json::object();
  for (const char* kind : {"wear", "geometry", "radius", "work", "variable", "parameter", "tool_life"}) {
    const auto found = limits.find(kind);
    answer[kind] = found != limits.end() ? json(found->second) : json(nullptr);
  }
  co_return json_reply(answer);
}

awaitable<Reply> change_limits(Services& s, Call& call, std::int64_t machine) {
  const auto actor = actor_of(call);
  const json limits = call.body;
  std::vector<std::pair<std::string, std::optional<double>>> wanted;
  for (const auto& [kind, step] : limits.items()) wanted.emplace_back(kind, member_or_null(limits, kind.c_str()));
  const auto in_store = [&](db::Database& db) {
    db::Transaction transaction(db);
    if (machine != 0) fleet::require_machine(db, machine);
    for (const auto& [kind, step] : wanted) fleet::set_value_limit(db, actor, machine, kind, step);
    transaction.commit();
  };
  co_await s.store.run(in_store);
  co_return co_await limits_of(s, machine);
}

std::vector<Route> ruling(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/value-limits", .role = Role::viewer,
                    .summary = "The largest change one person may make, by kind; null: any", .response = "ValueLimits",
                    .handler = [&s](Call&) -> awaitable<Reply> { co_return co_await limits_of(s, 0); }});
  routes.push_back({.method = Method::patch, .pattern = "/value-limits", .role = needs(Action::edit_offsets),
                    .summary = "Change the shop's limits", .takes = Takes::json, .request = "ValueLimits", .response = "ValueLimits",
                    .errors = {"bad_value"}, .handler = [&s](Call& call) -> awaitable<Reply> { co_return co_await change_limits(s, call, 0); }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/value-limits", .role = Role::viewer,
                    .summary = "Those that hold for this machine", .response = "ValueLimits",
                    .handler = [&s](Call& call) -> awaitable<Reply> { co_return co_await limits_of(s, call.id("id")); }});
  routes.push_back({.method = Method::patch, .pattern = "/machines/{id}/value-limits", .role = needs(Action::edit_offsets),
                    .summary = "Limits of its own; null: the shop's again", .takes = Takes::json, .request = "ValueLimits", .response = "ValueLimits",
                    .errors = {"bad_value"}, .handler = [&s](Call& call) -> awaitable<Reply> { co_return co_await change_limits(s, call, call.id("id")); }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/snapshots", .role = Role::viewer,
                    .summary = "Values kept under a name", .response = "Snapshots", .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto rows = co_await s.store.run([id](db::Database& db) {
                        fleet::require_machine(db, id);
                        return db::snapshots(db, id);
                      });
                      co_return json_reply(list_json(rows));
                    }});
  routes.push_back({.method = Method::post, .pattern = "/machines/{id}/snapshots", .role = needs(Action::edit_offsets),
                    .summary = "Keep everything the machine has now under a name", .takes = Takes::json, .request = "NewSnapshot",
                    .response = "Snapshot", .status = 201, .errors = {"bad_name", "machine_not_read"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto id = call.id("id");
                      const auto name = call.body_text("name");
                      const auto in_store = [&](db::Database& db) { return fleet::take_snapshot(db, actor, id, name, db::now_ms()); };
                      const auto row = co_await s.store.run(in_store);
                      co_return json_reply(to_json(row), 201);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/tool-life", .role = Role::viewer,
                    .summary = "Life left and when the next change comes, the soonest first", .response = "ToolLife",
                    .query = {{"machine", "integer", "only this machine"}}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.number("machine", 0);
                      std::string policy;
                      const auto in_store = [&](db::Database& db) {
                        policy = fleet::to_string(fleet::short_life_policy(db));
                        return fleet::tool_life(db, machine, db::now_ms());
                      };
                      const auto groups = co_await s.store.run(in_store);
                      json answer = list_json(groups);
                      answer["short_life"] = policy;
                      co_return json_reply(answer);
                    }});
  routes.push_back({.method = Method::patch, .pattern = "/tool-life", .role = needs(Action::edit_offsets),
                    .summary = "Whether a run that needs more life than is left is refused, warned of, or neither", .takes = Takes::json,
                    .request = "ToolLifePolicy", .response = "ToolLifePolicy", .errors = {"bad_value"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto policy = call.body_text("short_life");
                      const auto in_store = [&](db::Database& db) { fleet::set_short_life_policy(db, actor, policy); };
                      co_await s.store.run(in_store);
                      co_return json_reply({{"short_life", policy}});
                    }});
  return routes;
}

}  // namespace

std::vector<Route> value_routes(Services& s) {
  return joined(s, {reading_values, writing, ruling});
}

}  // namespace headstock::api
