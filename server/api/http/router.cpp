#include "server/api/http/router.hpp"

#include <array>
#include <charconv>
#include <stdexcept>

namespace headstock::api {

namespace {

constexpr std::array<std::string_view, 6> role_names = {"",           "viewer", "operator",
                                                         "programmer", "setter", "administrator"};

std::vector<std::string> split(std::string_view path) {
  std::vector<std::string> parts;
  std::size_t at = 0;
  while (at < path.size()) {
    if (path[at] == '/') {
      ++at;
      continue;
    }
    const auto end = std::min(path.find('/', at), path.size());
    parts.emplace_back(path.substr(at, end - at));
    at = end;
  }
  return parts;
}

bool is_parameter(std::string_view segment) { return segment.size() > 2 && segment.front() == '{'; }

bool fits(const std::vector<std::string>& pattern, const std::vector<std::string>& path,
          std::map<std::string, std::string>& parameters) {
  if (pattern.size() != path.size()) return false;
  for (std::size_t i = 0; i < pattern.size(); ++i)
    if (!is_parameter(pattern[i]) && pattern[i] != path[i]) return false;
  for (std::size_t i = 0; i < pattern.size(); ++i)
    if (is_parameter(pattern[i])) parameters[pattern[i].substr(1, pattern[i].size() - 2)] = path[i];
  return true;
}

template <class Number>
bool parse(const std::string& text, Number& out) {
  const auto* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, out);
  return error == std::errc() && at == end;
}

}  // namespace

std::string_view to_string(Role role) { return role_names[static_cast<std::size_t>(role)]; }

Role role_from(std::string_view name) {
  for (std::size_t i = 1; i < role_names.size(); ++i)
    if (role_names[i] == name) return static_cast<Role>(i);
  return Role::none;
}

std::string_view to_string(Method method) {
  constexpr std::array<std::string_view, 4> names = {"GET", "POST", "PATCH", "DELETE"};
  return names[static_cast<std::size_t>(method)];
}

void Router::add(std::vector<Route> routes) {
  for (auto& route : routes) {
    auto pattern = split(route.pattern);
    for (std::size_t i = 0; i < routes_.size(); ++i)
      if (routes_[i].method == route.method && segments_[i] == pattern)
        throw std::logic_error("two routes for " + std::string(to_string(route.method)) + " " + route.pattern);
    segments_.push_back(std::move(pattern));
    routes_.push_back(std::move(route));
  }
}

Router::Match Router::match(Method method, std::string_view path) const {
  Match match;
  const auto wanted = split(path);
  for (std::size_t i = 0; i < routes_.size(); ++i) {
    std::map<std::string, std::string> parameters;
    if (!fits(segments_[i], wanted, parameters)) continue;
    if (routes_[i].method == method) {
      match.route = &routes_[i];
      match.parameters = std::move(parameters);
      match.allow.clear();
      return match;
    }
    if (!match.allow.empty()) match.allow += ", ";
    match.allow += to_string(routes_[i].method);
  }
  return match;
}

bool may(const Principal& who, const Need& need, std::int64_t machine) {
  if (need.role == Role::none) return true;
  if (!who.rights) return who.role >= need.role;
  if (need.action) return who.rights->may(*need.action, machine);
  return role_from(access::to_string(who.rights->role_on(machine))) >= need.role;
}

bool names_machines(const Route& route) {
  if (route.method == Method::get) return false;
  for (const std::string_view prefix : {"/machines/{id}", "/ports/{id}", "/transfers/{id}", "/distributions"})
    if (route.pattern.starts_with(prefix)) return true;
  return route.pattern == "/programs/{id}/revisions/{n}/check" || route.pattern == "/alarm-events/{id}/acknowledge";
}

std::string admission(const Route& route, const Principal& who, bool by_cookie, const Headers& headers,
                      std::int64_t machine) {
  if (route.role != Role::none && who.role == Role::none) return "unauthenticated";
  const bool own_session = route.pattern.starts_with("/session");
  if (route.role != Role::none && who.must_change_password && !own_session) return "must_change_password";
  const bool ends_it = route.pattern == "/session" && route.method == Method::del;
  if (route.role != Role::none && who.look_only && route.method != Method::get && !ends_it) return "look_only";
  if (!may(who, route.role, machine)) return "forbidden";
  if (route.role != Role::none && by_cookie && route.method != Method::get && headers.x_headstock != "1")
    return "cross_site";
  return "";
}

std::int64_t Call::id(const std::string& name) const {
  std::int64_t value = 0;
  const auto found = request.parameters.find(name);
  if (found == request.parameters.end() || !parse(found->second, value) || value < 0) throw Refused("not_found", name);
  return value;
}

std::string Call::text(const std::string& name, const std::string& fallback) const {
  const auto found = request.query.find(name);
  return found == request.query.end() ? fallback : found->second;
}

std::int64_t Call::number(const std::string& name, std::int64_t fallback) const {
  const auto found = request.query.find(name);
  if (found == request.query.end() || found->second.empty()) return fallback;
  std::int64_t value = 0;
  if (!parse(found->second, value)) throw Refused("bad_request", name);
  return value;
}

std::string Call::body_text(const std::string& name) const {
  const auto found = body.find(name);
  if (found == body.end() || !found->is_string()) throw Refused("bad_request", name);
  return found->get<std::string>();
}

std::string Call::body_text(const std::string& name, const std::string& fallback) const {
  const auto found = body.find(name);
  if (found == body.end() || found->is_null()) return fallback;
  if (!found->is_string()) throw Refused("bad_request", name);
  return found->get<std::string>();
}

std::int64_t Call::body_number(const std::string& name) const {
  const auto found = body.find(name);
  if (found == body.end() || !found->is_number_integer()) throw Refused("bad_request", name);
  return found->get<std::int64_t>();
}

}  // namespace headstock::api
