// The controllers' own password levels and the roles they become. What a level may change on the control is what the
// role may change over the network, never more.
#pragma once

#include <span>
#include <string_view>

#include "server/access/role.hpp"

namespace headstock::access {

struct ProtectionLevel {
  std::string_view level;    ///< as the control calls it
  std::string_view name_en, name_zh;
  std::string_view may_en, may_zh;  ///< what it opens on the control
  Role role;                 ///< the least role here that may do the same
  std::string_view source;   ///< of the manual
};

/// From the highest to the lowest; empty for an unknown profile.
std::span<const ProtectionLevel> protection_levels(std::string_view profile);

}  // namespace headstock::access
