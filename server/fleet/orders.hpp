// Orders: so many parts of a program, on one machine or wherever it is made. What is done is counted from the
// parts themselves, less what was rejected. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "server/access/role.hpp"

namespace headstock::fleet {

struct Order {
  std::int64_t id = 0;
  std::string name = {};
  std::int64_t machine = 0;  ///< 0: any
  std::string program = {};  ///< as the machines name it; empty: any
  std::int64_t required = 0, from_ms = 0;
  std::string by = {};
  std::optional<std::int64_t> closed_ms = {};
  std::string closed_by = {};
  std::int64_t made = 0, rejected = 0;
};
std::vector<Order> orders(db::Database& db, bool open_only);
/// Refusals: forbidden, bad_name, bad_value, not_found.
Order make_order(db::Database& db, const access::Actor& actor, Order order, std::int64_t now_ms);
/// Refusals: forbidden, not_found, already_decided.
Order close_order(db::Database& db, const access::Actor& actor, std::int64_t id, std::int64_t now_ms);

}  // namespace headstock::fleet
