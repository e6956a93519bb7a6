// What one person may do, where: the shop-wide role, and what was granted or forbidden on machines, groups and single
// actions. Looking is shop-wide: who signs in sees every machine.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/access_store.hpp"
#include "server/access/role.hpp"

namespace headstock::access {

/// Not about one machine: only what holds everywhere counts.
inline constexpr std::int64_t kNoMachine = 0;
/// On at least one machine: to refuse at once who could never, before it is known which machine is meant.
inline constexpr std::int64_t kAnyMachine = -1;

class Rights {
 public:
  struct Grant {
    std::optional<std::vector<std::int64_t>> machines;  ///< nothing: everywhere
    std::optional<Role> role;                           ///< at least this role there
    std::optional<Action> action;                       ///< this action, allowed or forbidden there
    bool allow = true;
  };
  Rights(Role base, std::vector<Grant> grants) : base_(base), grants_(std::move(grants)) {}

  /// The shop-wide role, raised by what was granted on the machine.
  Role role_on(std::int64_t machine) const;
  /// A prohibition beats every permission; a permission of the action beats the role.
  bool may(Action action, std::int64_t machine) const;
  /// The machines on which the role is higher than shop-wide.
  std::map<std::int64_t, Role> raised() const;

 private:
  bool holds(const Grant& grant, std::int64_t machine) const;
  Role base_;
  std::vector<Grant> grants_;
};

/// ---- store thread
std::shared_ptr<const Rights> rights_of(db::Database& db, std::int64_t user, Role base);

/// Refusals: forbidden, not_found, bad_role, bad_value (unknown action; a machine and a group at once), and
/// last_administrator when somebody would forbid the users' page to the last one who has it.
void set_grants(db::Database& db, const Actor& actor, std::int64_t user, const std::vector<db::GrantRow>& grants);
/// Refusals: forbidden, not_found, bad_name, name_taken.
std::int64_t put_group(db::Database& db, const Actor& actor, const db::GroupRow& group);
void remove_group(db::Database& db, const Actor& actor, std::int64_t id);

}  // namespace headstock::access
