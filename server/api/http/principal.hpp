// Who makes a request, and what that lets them do.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace headstock::api {

/// Each role includes the ones before it.
enum class Role : std::uint8_t { none, viewer, operate, program, setter, administrator };

/// The names in the interface: "viewer", "operator", "programmer", "setter", "administrator"; "" for none.
std::string_view to_string(Role role);
/// `none` for an unknown name.
Role role_from(std::string_view name);

struct Principal {
  std::int64_t user_id = 0;
  std::string user, name, language;
  Role role = Role::none;
  std::string token;              ///< the session's token as the client sent it
  std::int64_t expires_ms = 0;    ///< Unix time; 0: unknown
  bool must_change_password = false;
};

}  // namespace headstock::api
