#include "db/store.hpp"
#include "db/time.hpp"
#include "server/api/openapi.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;

json profiles() {
  struct Row {
    const char *id, *en, *zh, *kind;
  };
  static constexpr Row rows[] = {
      {"fanuc-0i-t", "FANUC 0i-TD, turning", "FANUC 0i-TD 车床", "lathe"},
      {"fanuc-0i-m", "FANUC 0i-MD, milling", "FANUC 0i-MD 铣床", "mill"},
      {"gsk-2000tc", "GSK 2000TC, turning centre", "广数 GSK2000TC 车削中心", "lathe"},
      {"gsk-218t", "GSK 218T, turning", "广数 GSK218T 车床", "lathe"},
      {"k2000tc", "K2000TC, turning centre", "K2000TC 车削中心", "lathe"},
      {"lathe-200t", "200T, turning", "200T 车床", "lathe"},
  };
  json items = json::array();
  for (const auto& row : rows)
    items.push_back({{"id", row.id}, {"name", {{"en", row.en}, {"zh", row.zh}}}, {"kind", row.kind}});
  return {{"items", std::move(items)}, {"next", nullptr}};
}

}  // namespace

std::vector<Route> system_routes(Services& s, const Router& router) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/health", .role = Role::none,
                    .summary = "Does the server answer, and its store too", .response = "Health",
                    .handler = [&s](Call&) -> awaitable<Reply> {
                      // Through the store's thread: a server that cannot reach its data is not well.
                      co_await s.store.run([](db::Database& db) { return db.integer("SELECT 1").value_or(0); });
                      co_return json_reply({{"status", "ok"}, {"version", s.version}, {"now", time_json(db::now_ms())}});
                    }});
  routes.push_back({.method = Method::get, .pattern = "/openapi.json", .role = Role::none,
                    .summary = "This description", .response = "Document",
                    .handler = [&s, &router, document = std::make_shared<std::string>()](Call&) -> awaitable<Reply> {
                      if (document->empty()) *document = openapi(router, s.version).dump();
                      Reply reply;
                      reply.content_type = "application/json; charset=utf-8";
                      reply.fixed = *document;   // kept by the route
                      co_return reply;
                    }});
  routes.push_back({.method = Method::get, .pattern = "/profiles", .role = Role::viewer,
                    .summary = "The six controllers", .response = "Profiles",
                    .handler = [](Call&) -> awaitable<Reply> { co_return json_reply(profiles()); }});
  routes.push_back({.method = Method::get, .pattern = "/events", .role = Role::viewer,
                    .summary = "Live states and events as a WebSocket", .takes = Takes::web_socket,
                    .handler = nullptr});
  return routes;
}

}  // namespace headstock::api
