#include <algorithm>
#include <charconv>
#include <chrono>

#include <nlohmann/json.hpp>

#include "protocol/wire/reasons.hpp"
#include "server/api/routes/routes.hpp"
#include "server/fleet/changes.hpp"

namespace headstock::api {

const std::vector<Query> paging = {{"cursor", "string", "`next` of the piece before"},
                                   {"limit", "integer", "1…1000, 100 unless told"}};
const std::vector<Query> period = {{"from", "string", "time, inclusive"}, {"to", "string", "time, exclusive"}};

std::vector<Query> with(std::vector<Query> first, const std::vector<Query>& more) {
  first.insert(first.end(), more.begin(), more.end());
  return first;
}

std::vector<Route> joined(Services& services, std::initializer_list<RoutePart> parts) {
  std::vector<Route> routes;
  for (const RoutePart part : parts)
    for (Route& route : part(services)) routes.push_back(std::move(route));
  return routes;
}

Need needs(access::Action action) { return {role_from(access::to_string(access::required(action))), action}; }

access::Actor actor_of(const Call& call) {
  access::Actor actor;
  actor.user_id = call.who.user_id;
  actor.user = call.who.user;
  // A route without sign-in must not act as the server itself.
  actor.role = access::role_from(to_string(call.who.role)).value_or(access::Role::viewer);
  actor.address = call.request.peer;
  actor.rights = call.who.rights;
  actor.machines = call.machines;
  if (actor.rights && !actor.machines.empty()) {
    actor.role = access::Role::administrator;
    for (const auto machine : actor.machines) actor.role = std::min(actor.role, actor.rights->role_on(machine));
  }
  return actor;
}

db::Page page_of(const Call& call) {
  db::Page page;
  page.before = call.number("cursor", 0);
  const auto limit = call.number("limit", 100);
  if (page.before < 0) throw Refused("bad_request", "cursor");
  if (limit < 1 || limit > 1000) throw Refused("bad_request", "limit");
  page.limit = static_cast<int>(limit);
  return page;
}

void announce_program(Services& services, const char* what, std::int64_t program) {
  services.changes.publish({"program", 0, std::make_shared<const nlohmann::json>(nlohmann::json{{"change", what}, {"id", program}})});
}

namespace {

/// Reads exactly `digits` digits at the front of `text` and drops them.
bool take_number(std::string_view& text, std::size_t digits, int& out) {
  if (text.size() < digits) return false;
  const auto* end = text.data() + digits;
  const auto [at, error] = std::from_chars(text.data(), end, out);
  if (error != std::errc() || at != end || out < 0) return false;
  text.remove_prefix(digits);
  return true;
}

bool take(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

std::optional<std::int64_t> parse_time(const std::string& text) {
  if (text.size() > 10 && text.find_first_not_of("0123456789") == std::string::npos) {
    std::int64_t ms = 0;
    const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), ms);
    return error == std::errc() ? std::optional(ms) : std::nullopt;
  }
  std::string_view rest = text;
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, ms = 0;
  if (!take_number(rest, 4, year) || !take(rest, '-') || !take_number(rest, 2, month) || !take(rest, '-') ||
      !take_number(rest, 2, day))
    return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  if (!rest.empty()) {
    if (!take(rest, 'T') || !take_number(rest, 2, hour) || !take(rest, ':') || !take_number(rest, 2, minute))
      return std::nullopt;
    if (take(rest, ':') && !take_number(rest, 2, second)) return std::nullopt;
    if (take(rest, '.') && !take_number(rest, 3, ms)) return std::nullopt;
    if (!rest.empty() && !take(rest, 'Z')) return std::nullopt;
    if (!rest.empty() || hour > 23 || minute > 59 || second > 60) return std::nullopt;
  }
  using namespace std::chrono;
  const auto moment = sys_days(date) + hours(hour) + minutes(minute) + seconds(second) + milliseconds(ms);
  return duration_cast<milliseconds>(moment.time_since_epoch()).count();
}

std::optional<std::int64_t> time_of(const Call& call, const std::string& name) {
  const auto text = call.text(name);
  if (text.empty()) return std::nullopt;
  const auto time = parse_time(text);
  if (!time) throw Refused("bad_request", name);
  return time;
}

Reply machine_refusal(const std::string& reason) {
  const auto text = protocol::reason_text(reason);
  return json_reply({{"accepted", false},
                     {"reason", reason},
                     {"error",
                      {{"code", "machine_refused"},
                       {"message", {{"en", text.en}, {"zh", text.zh}}},
                       {"where", reason}}}},
                    409);
}

}  // namespace headstock::api
