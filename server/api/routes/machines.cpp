#include <algorithm>
#include <array>

#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/access/audit.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/routes/value_shapes.hpp"
#include "server/api/shapes.hpp"
#include "server/fleet/fleet.hpp"
#include "server/fleet/machines.hpp"
#include "server/gateway/gateway.hpp"
#include "server/library/distribution.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;
using access::Action;

/// What may be asked of a machine over the network at all. Arming remote operation, releasing an emergency stop,
/// changing the mode, dry run and machine lock belong to the person who stands at the machine.
constexpr std::array<std::string_view, 12> remote_actions = {
    "cycle_start",          "feed_hold",        "reset",             "emergency_stop",     "set_feed_override",
    "set_rapid_override",   "set_single_block", "set_optional_stop", "set_block_skip",     "set_spindle_override",
    "set_parts_required",   "reset_parts"};

/// Written after the machine has answered, without letting the answer wait for the disk.
void audit(Services& s, const access::Actor& actor, const char* action, std::int64_t machine, const std::string& what,
           const server::MachineAnswer& answer) {
  s.store.post("the audit row of a command", [=](db::Database& db) {
    db::Transaction transaction(db);
    access::record(db, actor, action, "machine:" + std::to_string(machine),
                   {{"what", what}, {"result", answer.accepted ? "accepted" : answer.reason}});
    transaction.commit();
  });
}

awaitable<db::MachineRow> require(Services& s, std::int64_t id) {
  co_return co_await s.store.run([id](db::Database& db) { return fleet::require_machine(db, id); });
}

json with_live(Services& s, const db::MachineRow& row, bool detailed) {
  json machine = to_json(row, detailed);
  machine["live"] = s.fleet.live_of(row.id);
  return machine;
}

awaitable<std::string> new_token(Services& s, access::Actor actor, std::int64_t machine) {
  const auto secret = co_await s.store.run(
      [&](db::Database& db) { return fleet::issue_token(db, actor, machine, db::now_ms()); });
  co_return "HS1-" + secret + "-" + s.gateway.ca_fingerprint();
}

Reply answered(const server::MachineAnswer& answer) {
  if (!answer.accepted) return machine_refusal(answer.reason);
  return json_reply({{"accepted", true}, {"reason", nullptr}});
}

/// Refuses what the tools left do not last for, or tells it, as the shop has chosen.
/// @param name the program; empty: the one selected now @return the groups that are short, when only told
awaitable<json> demand_tool_life(Services& s, std::int64_t machine, std::string name) {
  if (name.empty()) {
    const json live = s.fleet.live_of(machine);
    if (live.is_object() && live.contains("program") && live["program"].is_object()) name = live["program"].value("name", "");
    // A run that is held or stopped goes on; it is not begun again.
    if (!live.is_object() || live.value("state", "") != "idle") co_return json::array();
  }
  auto policy = fleet::ShortLife::off;
  const auto in_store = [&](db::Database& db) {
    policy = fleet::short_life_policy(db);
    return policy == fleet::ShortLife::off ? std::vector<fleet::LifeNeed>() : fleet::short_lives(db, machine, name);
  };
  const auto lacking = co_await s.store.run(in_store);
  json warnings = json::array();
  for (const auto& one : lacking) warnings.push_back(to_json(one));
  if (!lacking.empty() && policy == fleet::ShortLife::refuse)
    throw db::Refusal("tool_life_short", "group " + std::to_string(lacking.front().group));
  co_return warnings;
}

void announce(Services& s, const char* what, std::int64_t machine) {
  s.changes.publish({"machine", machine, std::make_shared<const json>(json{{"change", what}, {"id", machine}, {"removed", std::string_view(what) == "removed"}})});
}

std::vector<Route> managing(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/machines", .role = Role::viewer,
                    .summary = "All machines with their live state", .response = "Machines",
                    .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto rows = co_await s.store.run([](db::Database& db) { return db::machines(db); });
                      json items = json::array();
                      for (const auto& row : rows) items.push_back(with_live(s, row, false));
                      co_return json_reply({{"items", std::move(items)}, {"next", nullptr}});
                    }});
  routes.push_back(
      {.method = Method::post, .pattern = "/machines", .role = needs(Action::manage_machines),
       .summary = "Create a machine; the answer holds a token with which its agent can enrol once",
       .takes = Takes::json, .request = "NewMachine", .response = "NewMachineAnswer", .status = 201,
       .errors = {"bad_name", "name_taken", "bad_profile", "bad_machine_file"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto actor = actor_of(call);
         const auto name = call.body_text("name"), profile = call.body_text("profile"), toml = call.body_text("toml", "");
         const auto row = co_await s.store.run([&](db::Database& db) {
           return fleet::create_machine(db, actor, name, profile, toml, db::now_ms());
         });
         const auto token = co_await new_token(s, actor, row.id);
         co_await s.fleet.refresh();
         announce(s, "created", row.id);
         json answer = with_live(s, row, true);
         answer["enrolment_token"] = token;
         co_return json_reply(answer, 201);
       }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}", .role = Role::viewer,
                    .summary = "One machine with its axes, limits and live state", .response = "Machine",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await require(s, call.id("id"));
                      co_return json_reply(with_live(s, row, true));
                    }});
  routes.push_back(
      {.method = Method::patch, .pattern = "/machines/{id}", .role = needs(Action::edit_machine),
       .summary = "Change name, machine file or parts required", .takes = Takes::json, .request = "MachineChange",
       .response = "Machine", .errors = {"bad_name", "name_taken", "bad_machine_file", "bad_value"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         fleet::MachineChange change;
         if (call.body.contains("name")) change.name = call.body_text("name");
         if (call.body.contains("toml")) change.toml = call.body_text("toml");
         if (call.body.contains("parts_required")) change.parts_required = call.body_number("parts_required");
         const auto actor = actor_of(call);
         const auto id = call.id("id");
         const auto row = co_await s.store.run([&](db::Database& db) {
           return fleet::change_machine(db, actor, id, change, db::now_ms());
         });
         co_await s.fleet.refresh();
         announce(s, "changed", id);
         co_return json_reply(with_live(s, row, true));
       }});
  routes.push_back({.method = Method::del, .pattern = "/machines/{id}", .role = needs(Action::manage_machines),
                    .summary = "Remove a machine; its history stays", .status = 204,
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto id = call.id("id");
                      co_await s.store.run(
                          [&](db::Database& db) { fleet::remove_machine(db, actor, id, db::now_ms()); });
                      s.gateway.drop(id, "removed");
                      co_await s.fleet.refresh();
                      announce(s, "removed", id);
                      co_return empty_reply();
                    }});
  routes.push_back(
      {.method = Method::post, .pattern = "/machines/{id}/enrolment", .role = needs(Action::enrol_machine),
       .summary = "A new one-time token; using it revokes the machine's old certificate", .takes = Takes::json,
       .response = "EnrolmentToken", .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto token = co_await new_token(s, actor_of(call), call.id("id"));
         co_return json_reply({{"enrolment_token", token},
                               {"expires", time_json(db::now_ms() + fleet::kTokenLifeMs)}});
       }});
  return routes;
}

std::vector<Route> operating(Services& s) {
  std::vector<Route> routes;
  routes.push_back(
      {.method = Method::post, .pattern = "/machines/{id}/commands", .role = needs(Action::command_machine),
       .summary = "Ask the machine for something; 409 with its reason when it refuses", .takes = Takes::json,
       .request = "Command", .response = "MachineAnswer", .errors = {"machine_refused", "bad_request", "tool_life_short"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto action = call.body_text("action");
         if (std::ranges::find(remote_actions, action) == remote_actions.end()) throw Refused("bad_request", "action");
         double value = 0;
         if (const auto given = call.body.find("value"); given != call.body.end() && !given->is_null()) {
           if (given->is_boolean())
             value = given->get<bool>() ? 1 : 0;
           else if (given->is_number())
             value = given->get<double>();
           else
             throw Refused("bad_request", "value");
         }
         const auto row = co_await require(s, call.id("id"));
         if (action == "cycle_start") co_await demand_tool_life(s, row.id, "");
         const auto answer = co_await s.gateway.command(row.id, action, value, call.who.user);
         audit(s, actor_of(call), "machine.command", row.id, action + " " + json(value).dump(), answer);
         co_return answered(answer);
       }});
  routes.push_back(
      {.method = Method::post, .pattern = "/machines/{id}/select", .role = needs(Action::select_program),
       .summary = "Choose a resident program", .takes = Takes::json, .request = "Select", .response = "MachineAnswer",
       .errors = {"machine_refused", "tool_life_short"}, .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto name = call.body_text("name");
         const auto row = co_await require(s, call.id("id"));
         const auto warning = co_await demand_tool_life(s, row.id, name);
         const auto answer = co_await s.gateway.select(row.id, name, call.who.user);
         audit(s, actor_of(call), "machine.select", row.id, name, answer);
         if (!answer.accepted) co_return machine_refusal(answer.reason);
         co_return json_reply({{"accepted", true}, {"reason", nullptr}, {"warnings", warning}});
       }});
  routes.push_back(
      {.method = Method::post, .pattern = "/machines/{id}/drip", .role = needs(Action::open_drip),
       .summary = "Open a drip-feed of a released revision", .takes = Takes::json, .request = "Drip",
       .response = "Transfer", .status = 201,
       .errors = {"not_released", "not_connected", "check_failed", "drip_open", "machine_refused"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto program = call.body_number("program_id"), revision = call.body_number("revision");
         const auto transfer = co_await s.distributor.drip(actor_of(call), call.id("id"), program, revision);
         co_return json_reply(to_json(transfer), 201);
       }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/programs", .role = Role::viewer,
                    .summary = "What is resident in the machine's memory", .response = "Residents",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto rows = co_await s.store.run([id](db::Database& db) {
                        fleet::require_machine(db, id);
                        return db::residents(db, id);
                      });
                      co_return json_reply(list_json(rows));
                    }});
  routes.push_back(
      {.method = Method::del, .pattern = "/machines/{id}/programs/{name}", .role = needs(Action::delete_resident),
       .summary = "Delete a program from the machine's memory", .response = "MachineAnswer",
       .errors = {"machine_refused"}, .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto name = call.request.parameters.at("name");
         const auto row = co_await require(s, call.id("id"));
         const auto answer = co_await s.gateway.delete_program(row.id, name);
         audit(s, actor_of(call), "machine.delete_program", row.id, name, answer);
         co_return answered(answer);
       }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/offsets", .role = Role::viewer,
                    .summary = "Offsets as last reported", .response = "Offsets",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      std::vector<db::OffsetRow> rows;
                      const auto machine = co_await s.store.run([&rows, id](db::Database& db) {
                        rows = db::offsets(db, id);
                        return fleet::require_machine(db, id);
                      });
                      json answer = list_json(rows);
                      answer["version"] = machine.offsets_version;
                      answer["reported"] = time_json(machine.offsets_at_ms);
                      co_return json_reply(answer);
                    }});
  return routes;
}

}  // namespace

std::vector<Route> machine_routes(Services& s) {
  auto routes = managing(s);
  auto more = operating(s);
  std::ranges::move(more, std::back_inserter(routes));
  return routes;
}

}  // namespace headstock::api
