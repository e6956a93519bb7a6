#include "db/store.hpp"
#include "server/access/audit.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"

namespace headstock::api {

using boost::asio::awaitable;

std::vector<Route> audit_routes(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/audit/verification", .role = needs(access::Action::read_audit),
                    .summary = "Is the chain of the audit trail whole? `last` and `hash`: of an earlier answer, to see "
                               "that its end was not cut off",
                    .response = "AuditVerification",
                    .query = {{"last", "integer", "id of the last row seen earlier"}, {"hash", "string", "its hash"}},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const db::AuditHead seen{call.number("last", 0), call.text("hash")};
                      const auto found = co_await s.store.run(
                          [&](db::Database& db) { return access::verify_audit(db, seen); });
                      co_return json_reply({{"whole", found.broken == 0},
                                            {"broken", found.broken != 0 ? json(found.broken) : json(nullptr)},
                                            {"what", found.what},
                                            {"rows", found.head.id},
                                            {"hash", found.head.hash}});
                    }});
  return routes;
}

}  // namespace headstock::api
