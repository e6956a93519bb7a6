// Tool life: groups of tools that replace each other. Data of a machine, part of interp::MachineData, and the
// rules of choosing and counting, which all controllers of the FANUC family share (0i-D 10.2, GSK 2000TC
// S002.0). No thread of its own: whoever holds the MachineData.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

namespace headstock::tools {

enum class LifeUnit : std::uint8_t {
  uses,   ///< one for each run of a program that uses the group
  tenths  ///< of a second of cutting
};

/// What the tool life page marks a tool with.
enum class LifeMark : char {
  available = ' ',
  in_use = '@',   ///< or used last
  expired = '*',  ///< its life is spent
  skipped = '#'   ///< passed over by the operator's tool skip
};

struct LifeTool {
  std::int32_t tool = 0;      ///< as the machine knows it
  std::int32_t offset = 0;    ///< turret: offset number in the T code
  std::int32_t h = 0, d = 0;  ///< changer: what H99 and D99 stand for; 0: none
  std::int64_t used = 0;      ///< in the group's unit; may go beyond the life when no other tool is left
  bool skipped = false;

  bool operator==(const LifeTool&) const = default;
};

struct LifeGroup {
  LifeUnit unit = LifeUnit::uses;
  std::int64_t life = 0;    ///< in the unit, > 0
  std::size_t current = 0;  ///< chosen last; search goes on from there
  std::vector<LifeTool>
      tools;  ///< in the order of use. Entries of one tool number in a row: one tool, several offsets

  bool operator==(const LifeGroup&) const = default;
};

/// The whole page.
struct LifeTable {
  std::map<std::int32_t, LifeGroup> groups;  ///< by group number
  bool change_due = false;                   ///< signal "tool change": the last tool of some group is spent
  std::int32_t notice_group =
      0;  ///< signal "life notice": this group's remaining life is at or below the notice; 0: none

  LifeGroup* find(std::int32_t number);
  const LifeGroup* find(std::int32_t number) const;
};

/// How the entries of one tool with several offsets share their life.
enum class SharedLife : bool { per_entry, per_tool };

bool spent(const LifeGroup& group, std::size_t entry);
LifeMark mark(const LifeGroup& group, std::size_t entry);

/// True when no tool of the group has life left.
bool all_spent(const LifeGroup& group);

/// The first entry of a tool with life left: the current one, else the next ones, round to the first. When
/// none is left: the last tool. Group must not be empty.
std::size_t choose(const LifeGroup& group);

/// The next offset of the same tool; the last one again when there is none.
std::size_t next_offset(const LifeGroup& group, std::size_t entry);

/// Adds to the life of the entry (and of those it shares its life with).
void use(LifeGroup& group, std::size_t entry, std::int64_t amount, SharedLife shared);

/// Life left of the group's current tool; never below 0.
std::int64_t remaining(const LifeGroup& group);

/// Tool skip (TLSKP): the current tool is passed over. @return false when there is nothing to skip.
bool skip_current(LifeGroup& group);

/// Tool change reset (TLRST): new tools are in the holders; the group begins again with its first tool.
void renew(LifeGroup& group);

}  // namespace headstock::tools
