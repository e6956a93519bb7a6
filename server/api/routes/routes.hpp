// The rows of the interface, one file a subject, and what their handlers share.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "db/page.hpp"
#include "server/access/role.hpp"
#include "server/api/http/router.hpp"
#include "server/api/services.hpp"

namespace headstock::api {

std::vector<Route> session_routes(Services& services);
std::vector<Route> user_routes(Services& services);
std::vector<Route> people_routes(Services& services);
std::vector<Route> audit_routes(Services& services);
std::vector<Route> alarm_rule_routes(Services& services);
std::vector<Route> backup_routes(Services& services);
std::vector<Route> provider_routes(Services& services);
std::vector<Route> machine_routes(Services& services);
std::vector<Route> program_routes(Services& services);
std::vector<Route> revision_routes(Services& services);
std::vector<Route> transfer_routes(Services& services);
std::vector<Route> history_routes(Services& services);
std::vector<Route> port_routes(Services& services);
std::vector<Route> port_record_routes(Services& services);
std::vector<Route> accounting_routes(Services& services);
std::vector<Route> value_routes(Services& services);
std::vector<Route> count_routes(Services& services);
/// Needs the router for the description it serves.
std::vector<Route> system_routes(Services& services, const Router& router);

/// All of them. `router` must outlive its use: the description reads it.
void add_all_routes(Router& router, Services& services);

/// The least role of an action: the table of server/access is the only one.
Need needs(access::Action action);
access::Actor actor_of(const Call& call);
/// The machines that a call is about, for its rights: of the path, the body, the port or the transfer it names.
boost::asio::awaitable<std::vector<std::int64_t>> machines_of(Services& services, const Route& route, const Call& call);
/// `?before=` / `?cursor=` and `?limit=`.
db::Page page_of(const Call& call);
/// A time of the query: ISO 8601 in UTC, a date, or Unix milliseconds. Throws Refused("bad_request").
std::optional<std::int64_t> time_of(const Call& call, const std::string& name);
/// @return nothing when malformed.
std::optional<std::int64_t> parse_time(const std::string& text);

/// Tells the pages that a program changed: "created", "moved", …
void announce_program(Services& services, const char* what, std::int64_t program);

/// 409 `{accepted:false,reason,error}`.
Reply machine_refusal(const std::string& reason);

/// Descriptions that several rows share.
extern const std::vector<Query> paging;
extern const std::vector<Query> period;
std::vector<Query> with(std::vector<Query> first, const std::vector<Query>& more);
/// The rows of several parts of one subject.
using RoutePart = std::vector<Route> (*)(Services&);
std::vector<Route> joined(Services& services, std::initializer_list<RoutePart> parts);

}  // namespace headstock::api
