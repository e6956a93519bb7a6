// Who makes a request, and what that lets them do.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/access/rights.hpp"

namespace headstock::api {

/// Each role includes the ones before it.
enum class Role : std::uint8_t { none, viewer, operate, program, setter, administrator };

/// The names in the interface: "viewer", "operator", "programmer", "setter", "administrator"; "" for none.
std::string_view to_string(Role role);
/// `none` for an unknown name.
Role role_from(std::string_view name);

/// What a route asks for: a role, and the action where it is one of server/access's table. Made from either.
struct Need {
  Role role = Role::viewer;
  std::optional<access::Action> action{};
  Need(Role least) : role(least) {}
  Need(Role least, access::Action of) : role(least), action(of) {}
  operator Role() const { return role; }
};

struct Principal {
  std::int64_t user_id = 0;
  std::string user, name, language;
  Role role = Role::none;
  std::string token;              ///< the session's token as the client sent it
  std::int64_t expires_ms = 0;    ///< Unix time; 0: unknown
  bool must_change_password = false;   ///< until then nothing but that
  bool look_only = false;         ///< a wall screen's secret: reads, whatever the role
  std::shared_ptr<const access::Rights> rights{};   ///< nothing: the role alone counts
};

/// May this person do it on the machine (kNoMachine: everywhere; kAnyMachine: on one at least)?
bool may(const Principal& who, const Need& need, std::int64_t machine);

}  // namespace headstock::api
