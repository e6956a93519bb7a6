// Tool life as the machines count it: what is left, when the next change comes, and whether what is left
// lasts for a run. The machine counts (controller-agent/tools); here is only what it has told. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "server/access/role.hpp"

namespace headstock::fleet {

struct LifeToolView {
  std::int64_t tool = 0, offset = 0, h = 0, d = 0;
  double used = 0;
  std::string mark;  ///< as on the machine's page: "@" in use, "*" spent, "#" skipped, "" ready
};
struct LifeGroupView {
  std::int64_t machine = 0;
  std::string machine_name;
  std::int64_t group = 0;
  std::string unit;  ///< uses seconds
  double life = 0;   ///< of one tool
  std::int64_t current = 0;
  double left_current = 0;              ///< of the tool in use, in the unit
  double left_total = 0;                ///< of all tools of the group that are not spent or skipped
  bool change_due = false;              ///< no tool of the group has life left
  bool notice = false;                  ///< the machine's own rest-life notice
  std::optional<double> per_part;       ///< used for a part, from what was counted lately; nothing: not known
  std::optional<double> parts_left;     ///< with the tool in use
  std::optional<double> next_change_s;  ///< at the pace of the last parts
  std::vector<LifeToolView> tools;
};
/// @param machine 0: the whole shop, the soonest change first
std::vector<LifeGroupView> tool_life(db::Database& db, std::int64_t machine, std::int64_t now_ms);

enum class ShortLife { refuse, warn, off };
ShortLife short_life_policy(db::Database& db);
std::string to_string(ShortLife policy);
/// Refusals: forbidden, bad_value.
void set_short_life_policy(db::Database& db, const access::Actor& actor, const std::string& policy);

struct LifeNeed {
  std::int64_t group = 0;
  std::string unit;
  double need = 0, left = 0;
};
/// The groups of which a run of the program resident under this name needs more than is left, by its last
/// check on this machine; empty when enough is left, or nothing is known of it.
std::vector<LifeNeed> short_lives(db::Database& db, std::int64_t machine, const std::string& resident);

}  // namespace headstock::fleet
