#include "db/event_store.hpp"
#include "db/store.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/fleet/machines.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;

const Query by_machine = {"machine", "integer", "only this machine"};

/// Machine from the path, if the route has one, otherwise from the query.
void fill(const Call& call, db::HistoryFilter& filter) {
  filter.machine = call.request.parameters.contains("id") ? call.id("id") : call.number("machine", 0);
  filter.from_ms = time_of(call, "from");
  filter.to_ms = time_of(call, "to");
}

/// A history of one machine refuses a machine that never was; without one it is the whole shop's.
template <class Filter, class Read>
awaitable<Reply> history(Services& s, Call& call, Filter filter, Read read) {
  fill(call, filter);
  const auto page = page_of(call);
  const bool of_path = call.request.parameters.contains("id");
  const auto look_up = [=](db::Database& db) {
    if (of_path) fleet::require_machine(db, filter.machine);
    return read(db, filter, page);
  };
  const auto list = co_await s.store.run(look_up);
  co_return json_reply(list_json(list));
}

awaitable<Reply> parts(Services& s, Call& call) {
  db::HistoryFilter filter;
  fill(call, filter);
  const auto page = page_of(call);
  const bool of_path = call.request.parameters.contains("id");
  std::int64_t total = 0;
  const auto list = co_await s.store.run([&](db::Database& db) {
    if (of_path) fleet::require_machine(db, filter.machine);
    total = db::part_total(db, filter);
    return db::parts(db, filter, page);
  });
  json answer = list_json(list);
  answer["total"] = total;
  co_return json_reply(answer);
}

}  // namespace

std::vector<Route> history_routes(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/runs", .role = Role::viewer,
                    .summary = "Runs of programs, newest first", .response = "Runs", .query = with(period, paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      co_return co_await history(s, call, db::HistoryFilter{}, db::runs);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/parts", .role = Role::viewer,
                    .summary = "Parts counted, newest first, and their total in that time", .response = "Parts",
                    .query = with(period, paging), .handler = [&s](Call& call) -> awaitable<Reply> {
                      co_return co_await parts(s, call);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/parts", .role = Role::viewer,
                    .summary = "Parts counted in the whole shop", .response = "Parts",
                    .query = with(with({by_machine}, period), paging), .handler = [&s](Call& call) -> awaitable<Reply> {
                      co_return co_await parts(s, call);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/machines/{id}/states", .role = Role::viewer,
                    .summary = "State intervals, oldest first, without holes", .response = "States", .query = period,
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      db::HistoryFilter filter;
                      fill(call, filter);
                      const auto rows = co_await s.store.run([filter](db::Database& db) {
                        fleet::require_machine(db, filter.machine);
                        return db::states(db, filter);
                      });
                      co_return json_reply(list_json(rows));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/alarms", .role = Role::viewer,
                    .summary = "Alarm history, newest first", .response = "Alarms",
                    .query = with(with({by_machine,
                                        {"code", "string", "exactly this code"},
                                        {"active", "boolean", "only alarms not cleared"},
                                        {"q", "string", "part of code, text, program or block"}},
                                       period),
                                  paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      db::AlarmFilter filter;
                      filter.code = call.text("code");
                      filter.text = call.text("q");
                      const auto active = call.text("active");
                      filter.active_only = active == "true" || active == "1";
                      co_return co_await history(s, call, filter, db::alarms);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/audit", .role = needs(access::Action::read_audit),
                    .summary = "Who did what, newest first", .response = "Audit",
                    .query = with(with({{"user", "string", "exactly"},
                                        {"action", "string", "exactly, such as program.release"},
                                        {"subject", "string", "exactly, such as program:7"}},
                                       period),
                                  paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      db::AuditFilter filter;
                      filter.user = call.text("user");
                      filter.action = call.text("action");
                      filter.subject = call.text("subject");
                      filter.from_ms = time_of(call, "from");
                      filter.to_ms = time_of(call, "to");
                      const auto page = page_of(call);
                      const auto rows = co_await s.store.run(
                          [&](db::Database& db) { return db::audit(db, filter, page); });
                      co_return json_reply(list_json(rows));
                    }});
  return routes;
}

}  // namespace headstock::api
