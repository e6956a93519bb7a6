// The table of the interface: every route's method, path, role, texts and handler stand in one row. The served OpenAPI
// description is made from the same rows (openapi.hpp), so that it cannot say something else than what is done.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "server/api/http/message.hpp"
#include "server/api/http/principal.hpp"

namespace headstock::api {

/// What a handler is given.
struct Call {
  Request request;
  Principal who;                 ///< role `none` on routes that need no sign-in and have none
  nlohmann::json body;           ///< of routes whose body is JSON; null otherwise
  Body* upload = nullptr;        ///< of routes whose body is bytes
  std::vector<std::int64_t> machines{};   ///< which it is about, where rights depend on them

  /// The number in `{name}` of the path. Throws Refused("not_found") when it is none.
  std::int64_t id(const std::string& name) const;
  /// Query parameters; the fallback when absent, Refused("bad_request", name) when not of the kind.
  std::string text(const std::string& name, const std::string& fallback = "") const;
  std::int64_t number(const std::string& name, std::int64_t fallback) const;
  /// Members of the JSON body. Throws Refused("bad_request", name) when missing or of another type.
  std::string body_text(const std::string& name) const;
  std::string body_text(const std::string& name, const std::string& fallback) const;
  std::int64_t body_number(const std::string& name) const;
};

using Handler = std::function<boost::asio::awaitable<Reply>(Call&)>;

enum class Takes : std::uint8_t {
  nothing, json,
  bytes,       ///< streamed to the handler
  web_socket   ///< the connection is handed to the event hub; no handler
};

/// A query parameter as the description names it. `type` is a JSON type name.
struct Query { std::string name, type, about; };

struct Route {
  Method method = Method::get;
  std::string pattern{};           ///< "/machines/{id}", below /api/v1
  Need role = Role::viewer;      ///< `none`: no sign-in needed
  std::string summary{};
  Takes takes = Takes::nothing;
  std::string request{};           ///< name of a schema in schemas.cpp; empty: no JSON body
  std::string response{};          ///< name of a schema; empty: no body; "bytes": octets
  unsigned status = 200;         ///< of success
  std::vector<Query> query{};
  std::vector<std::string> errors{};  ///< codes beyond those every route may give
  Handler handler{};
  /// Ends something: who was known a moment ago need not wait for the store, which may be the thing that is stuck.
  bool urgent = false;
};

/// Prefix of every route.
inline constexpr std::string_view api_prefix = "/api/v1";

class Router {
 public:
  /// Throws std::logic_error when two rows have one method and path.
  void add(std::vector<Route> routes);
  const std::vector<Route>& routes() const { return routes_; }

  struct Match {
    const Route* route = nullptr;
    std::map<std::string, std::string> parameters;
    std::string allow;           ///< methods the path has, when it exists with other methods only
  };
  /// @param path below the prefix, percent-decoded.
  Match match(Method method, std::string_view path) const;

 private:
  std::vector<Route> routes_;
  std::vector<std::vector<std::string>> segments_;   ///< of each route's pattern
};

/// @return the code of the refusal, empty when `who` may call `route`.
/// @param by_cookie the session came by cookie, so that a changing request needs `X-Headstock: 1`.
/// @param machine kAnyMachine while it is not known yet which one is meant.
std::string admission(const Route& route, const Principal& who, bool by_cookie, const Headers& headers,
                      std::int64_t machine = access::kNoMachine);

/// Does the path or the body of this route name machines on which the rights depend? What it names: WebHost::machines.
bool names_machines(const Route& route);

}  // namespace headstock::api
