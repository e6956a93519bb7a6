#include "server/api/http/dispatch.hpp"

#include <algorithm>
#include <array>

#include "db/database.hpp"
#include "protocol/process/log.hpp"
#include "server/api/http/csv.hpp"
#include "db/refusal.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;

std::string bearer(const Headers& headers) {
  constexpr std::string_view scheme = "Bearer ";
  if (headers.authorization.starts_with(scheme)) return headers.authorization.substr(scheme.size());
  return "";
}

/// A page of another site could open a socket with the user's cookie where SameSite is not honoured.
bool same_origin(const Headers& headers) {
  if (headers.origin.empty()) return true;
  const auto scheme = headers.origin.find("://");
  return scheme != std::string::npos && headers.origin.substr(scheme + 3) == headers.host;
}

awaitable<nlohmann::json> read_json(const Request& request, Body& body) {
  std::string text;
  std::array<char, 16 * 1024> piece;
  while (const auto got = co_await body.read(piece.data(), piece.size())) text.append(piece.data(), got);
  if (text.empty()) co_return nlohmann::json::object();
  // Forms of foreign pages can send text/plain and the like without asking; JSON they cannot.
  if (!request.headers.content_type.starts_with("application/json")) throw Refused("bad_content_type");
  // A hostile depth would overflow the stack of whoever walks the value.
  int depth = 0;
  bool too_deep = false;
  auto parsed = nlohmann::json::parse(
      text,
      [&](int level, nlohmann::json::parse_event_t, nlohmann::json&) {
        depth = std::max(depth, level);
        too_deep = too_deep || level > 32;
        return !too_deep;
      },
      false);
  if (parsed.is_discarded() || too_deep || !parsed.is_object()) throw Refused("bad_json");
  co_return parsed;
}

awaitable<Dispatched> serve(const Router& router, const WebHost& host, const Limits& limits, Request request,
                            BoundedBody& body) {
  Dispatched out;
  const bool api = request.path == "/api" || request.path.starts_with("/api/");
  if (!api) {
    if (request.method != Method::get) throw Refused("method_not_allowed");
    out.reply = host.file(request);
    co_return out;
  }
  Router::Match match;
  if (request.path.starts_with(std::string(api_prefix) + "/"))
    match = router.match(request.method, std::string_view(request.path).substr(api_prefix.size()));
  if (!match.route) {
    out.reply = error_reply(Refused(match.allow.empty() ? "not_found" : "method_not_allowed", request.path));
    if (!match.allow.empty()) out.reply.headers.emplace_back("Allow", match.allow);
    co_return out;
  }
  const Route& route = *match.route;
  Call call;
  call.request = std::move(request);
  call.request.parameters = std::move(match.parameters);
  std::string token = bearer(call.request.headers);
  const bool by_cookie = token.empty();
  if (by_cookie) token = cookie_value(call.request.headers.cookie, session_cookie);
  if (!token.empty()) {
    auto known = route.urgent && host.known ? host.known(token) : std::nullopt;
    if (known) call.who = std::move(*known);
    else call.who = co_await host.authenticate(token);
  }
  const bool named = host.machines && names_machines(route);
  const auto refused = admission(route, call.who, by_cookie, call.request.headers,
                                 named ? access::kAnyMachine : access::kNoMachine);
  if (!refused.empty()) throw Refused(refused);

  switch (route.takes) {
    case Takes::nothing:
      body.limit = 0;
      break;
    case Takes::json:
      body.limit = limits.json_bytes;
      break;
    case Takes::bytes:
      body.limit = limits.upload_bytes;
      break;
    case Takes::web_socket:
      if (!same_origin(call.request.headers)) throw Refused("cross_site", "Origin");
      out.socket_for = std::move(call.who);
      co_return out;
  }
  if (body.announced() && *body.announced() > body.limit && route.takes != Takes::nothing) throw Refused("too_large");
  if (route.takes == Takes::json) call.body = co_await read_json(call.request, body);
  if (route.takes == Takes::bytes) call.upload = &body;
  if (named) {
    call.machines = co_await host.machines(route, call);
    if (call.machines.empty() && !may(call.who, route.role, access::kNoMachine)) throw Refused("forbidden");
    for (const auto machine : call.machines)
      if (!may(call.who, route.role, machine)) throw Refused("forbidden", "machine:" + std::to_string(machine));
  }
  if (route.method == Method::get && call.text("format") == "csv" && route.response != "bytes")
    out.reply = co_await csv_reply(route, call);
  else
    out.reply = co_await route.handler(call);
  co_return out;
}

Reply database_reply(const db::Error& error) {
  switch (error.problem()) {
    case db::Problem::disk_full: return error_reply(Refused("disk_full"));
    case db::Problem::lost: return error_reply(Refused("database_lost"));
    case db::Problem::locked: return error_reply(Refused("database_locked"));
    default: return error_reply(Refused("internal"));
  }
}

}  // namespace

awaitable<Dispatched> dispatch(const Router& router, const WebHost& host, const Limits& limits, Request request,
                               BoundedBody& body) {
  const std::string what = std::string(to_string(request.method)) + " " + request.path;
  Dispatched out;
  try {
    out = co_await serve(router, host, limits, std::move(request), body);
  } catch (const Refused& refused) {
    out.reply = error_reply(refused);
  } catch (const db::Refusal& refusal) {
    out.reply = error_reply(Refused(refusal.code(), refusal.where()));
  } catch (const db::Error& error) {
    log::error("{}: {}", what, error.what());
    out.reply = database_reply(error);
  } catch (const nlohmann::json::exception& error) {
    // A handler met a JSON body of another shape than it reads.
    log::info("{}: {}", what, error.what());
    out.reply = error_reply(Refused("bad_request"));
  } catch (const std::exception& error) {
    log::error("{}: {}", what, error.what());
    out.reply = error_reply(Refused("internal"));
  }
  co_return out;
}

void add_security_headers(Reply& reply) {
  static const std::array<std::pair<const char*, const char*>, 6> fields = {{
      {"X-Content-Type-Options", "nosniff"},
      {"X-Frame-Options", "DENY"},
      {"Referrer-Policy", "same-origin"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Permissions-Policy", "camera=(), microphone=(), geolocation=()"},
      // The editor writes its style sheet at run time; scripts come from this server only.
      {"Content-Security-Policy",
       "default-src 'self'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; "
       "connect-src 'self'; worker-src 'self' blob:; object-src 'none'; base-uri 'none'; form-action 'self'; "
       "frame-ancestors 'none'"},
  }};
  for (const auto& [name, value] : fields) reply.headers.emplace_back(name, value);
  if (!reply.cacheable) reply.headers.emplace_back("Cache-Control", "no-store");
}

std::string cookie_value(const std::string& header, const std::string& name) {
  std::size_t at = 0;
  while (at < header.size()) {
    const auto end = std::min(header.find(';', at), header.size());
    auto pair = std::string_view(header).substr(at, end - at);
    while (!pair.empty() && pair.front() == ' ') pair.remove_prefix(1);
    if (pair.size() > name.size() && pair.starts_with(name) && pair[name.size()] == '=')
      return std::string(pair.substr(name.size() + 1));
    at = end + 1;
  }
  return "";
}

namespace {

int hex(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

bool decode(std::string_view text, bool plus_is_space, std::string& out) {
  out.clear();
  for (std::size_t i = 0; i < text.size(); ++i) {
    char c = text[i];
    if (c == '%') {
      if (i + 2 >= text.size()) return false;
      const int high = hex(text[i + 1]), low = hex(text[i + 2]);
      if (high < 0 || low < 0) return false;
      c = static_cast<char>(high * 16 + low);
      i += 2;
    } else if (c == '+' && plus_is_space) {
      c = ' ';
    }
    if (c == '\0') return false;
    out += c;
  }
  return true;
}

}  // namespace

bool split_target(std::string_view target, std::string& path, std::map<std::string, std::string>& query) {
  if (target.empty() || target.front() != '/') return false;
  const auto mark = target.find('?');
  if (!decode(target.substr(0, mark), false, path)) return false;
  if (mark == std::string_view::npos) return true;
  auto rest = target.substr(mark + 1);
  while (!rest.empty()) {
    const auto end = std::min(rest.find('&'), rest.size());
    const auto pair = rest.substr(0, end);
    const auto equal = std::min(pair.find('='), pair.size());
    std::string name, value;
    if (!decode(pair.substr(0, equal), true, name)) return false;
    if (!decode(equal < pair.size() ? pair.substr(equal + 1) : std::string_view{}, true, value)) return false;
    if (!name.empty()) query[name] = value;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return true;
}

}  // namespace headstock::api
