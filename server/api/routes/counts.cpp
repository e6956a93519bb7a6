// Parts held against their witnesses, the recount, and orders.
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/routes/value_shapes.hpp"

namespace headstock::api {

using access::Action;
using boost::asio::awaitable;

std::vector<Route> count_routes(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/counts/recount", .role = Role::viewer,
                    .summary = "Totals read again from the raw events, held against the tables", .response = "Recounts",
                    .query = {{"machine", "integer", "only this machine"}}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.number("machine", 0);
                      const auto in_store = [machine](db::Database& db) { return fleet::recount(db, machine); };
                      const auto rows = co_await s.store.run(in_store);
                      co_return json_reply(list_json(rows));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/counts/disagreements", .role = Role::viewer,
                    .summary = "Where the part events and the machine's counter disagreed", .response = "Disagreements",
                    .query = with({{"machine", "integer", "only this machine"}}, paging), .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.number("machine", 0);
                      const auto page = page_of(call);
                      const auto in_store = [&](db::Database& db) { return fleet::disagreements(db, machine, page); };
                      const auto list = co_await s.store.run(in_store);
                      co_return json_reply(list_json(list));
                    }});
  routes.push_back({.method = Method::post, .pattern = "/counts/disagreements/{id}/seen", .role = needs(Action::note_downtime),
                    .summary = "A person has looked: its alarm ends", .takes = Takes::json, .status = 204,
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto id = call.id("id");
                      const auto in_store = [&](db::Database& db) { fleet::acknowledge(db, actor, id, db::now_ms()); };
                      co_await s.store.run(in_store);
                      co_return empty_reply();
                    }});
  routes.push_back({.method = Method::get, .pattern = "/orders", .role = Role::viewer, .summary = "Orders with what is made of them",
                    .response = "Orders", .query = {{"open", "boolean", "only open ones"}}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto open = call.text("open");
                      const bool open_only = open == "true" || open == "1";
                      const auto in_store = [open_only](db::Database& db) { return fleet::orders(db, open_only); };
                      const auto rows = co_await s.store.run(in_store);
                      co_return json_reply(list_json(rows));
                    }});
  routes.push_back({.method = Method::post, .pattern = "/orders", .role = needs(Action::note_downtime), .summary = "A new order",
                    .takes = Takes::json, .request = "NewOrder", .response = "Order", .status = 201, .errors = {"bad_name", "bad_value"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      fleet::Order order;
                      order.name = call.body_text("name");
                      order.program = call.body_text("program", "");
                      order.required = call.body_number("required");
                      if (call.body.contains("machine") && !call.body["machine"].is_null()) order.machine = call.body_number("machine");
                      if (const auto from = call.body_text("from", ""); !from.empty()) {
                        const auto time = parse_time(from);
                        if (!time) throw Refused("bad_request", "from");
                        order.from_ms = *time;
                      }
                      const auto in_store = [&](db::Database& db) { return fleet::make_order(db, actor, order, db::now_ms()); };
                      const auto made = co_await s.store.run(in_store);
                      co_return json_reply(to_json(made), 201);
                    }});
  routes.push_back({.method = Method::post, .pattern = "/orders/{id}/close", .role = needs(Action::note_downtime), .summary = "The order is over",
                    .takes = Takes::json, .response = "Order", .errors = {"already_decided"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto id = call.id("id");
                      const auto in_store = [&](db::Database& db) { return fleet::close_order(db, actor, id, db::now_ms()); };
                      const auto order = co_await s.store.run(in_store);
                      co_return json_reply(to_json(order));
                    }});
  return routes;
}

}  // namespace headstock::api
