#include "db/store.hpp"
#include "db/transfer_store.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/library/distribution.hpp"

namespace headstock::api {

using boost::asio::awaitable;
using access::Action;

std::vector<Route> transfer_routes(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::post, .pattern = "/distributions", .role = needs(Action::send_program),
                    .summary = "Send a released revision to machines: planned at once, then sent, a result for each",
                    .takes = Takes::json, .request = "NewDistribution", .response = "Distribution", .status = 201,
                    .errors = {"no_machines"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto program = call.body_number("program"), revision = call.body_number("revision");
                      const auto machines = call.body.at("machines").get<std::vector<std::int64_t>>();
                      const auto sent =
                          co_await s.distributor.distribute(actor_of(call), program, revision, machines);
                      co_return json_reply(to_json(sent), 201);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/distributions/{id}", .role = Role::viewer,
                    .summary = "A distribution with the progress of each machine", .response = "Distribution",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      auto row = co_await s.store.run([id](db::Database& db) { return db::distribution(db, id); });
                      if (!row) throw Refused("not_found", "distribution");
                      for (auto& transfer : row->transfers) {
                        const auto newest = co_await s.distributor.find(transfer.id);
                        if (newest) transfer = *newest;
                      }
                      co_return json_reply(to_json(*row));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/transfers", .role = Role::viewer,
                    .summary = "Transfers, newest first", .response = "Transfers",
                    .query = with({{"machine", "integer", "only this machine"}, {"open", "boolean", "only those under way"}},
                                  paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      db::TransferFilter filter;
                      filter.machine = call.number("machine", 0);
                      const auto open = call.text("open");
                      filter.open_only = open == "true" || open == "1";
                      const auto list = co_await s.distributor.list(filter, page_of(call));
                      co_return json_reply(list_json(list));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/transfers/{id}", .role = Role::viewer,
                    .summary = "One transfer", .response = "Transfer", .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await s.distributor.find(call.id("id"));
                      if (!row) throw Refused("not_found", "transfer");
                      co_return json_reply(to_json(*row));
                    }});
  routes.push_back({.method = Method::del, .pattern = "/transfers/{id}", .role = needs(Action::cancel_transfer),
                    .summary = "Cancel a transfer", .response = "Transfer", .errors = {"transfer_over"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await s.distributor.cancel(actor_of(call), call.id("id"));
                      co_return json_reply(to_json(row));
                    }});
  return routes;
}

}  // namespace headstock::api
