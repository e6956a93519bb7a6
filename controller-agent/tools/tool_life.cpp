#include "tools/tool_life.hpp"

#include <algorithm>

namespace headstock::tools {
namespace {

// The first and one past the last entry of the same tool in a row.
struct Run {
  std::size_t first, end;
};
Run run_of(const LifeGroup& group, std::size_t entry) {
  const std::int32_t tool = group.tools[entry].tool;
  Run run{entry, entry + 1};
  while (run.first > 0 && group.tools[run.first - 1].tool == tool) --run.first;
  while (run.end < group.tools.size() && group.tools[run.end].tool == tool) ++run.end;
  return run;
}

bool run_spent(const LifeGroup& group, Run run) {
  for (std::size_t i = run.first; i < run.end; ++i)
    if (!spent(group, i)) return false;
  return true;
}

}  // namespace

LifeGroup* LifeTable::find(std::int32_t number) {
  const auto found = groups.find(number);
  return found == groups.end() ? nullptr : &found->second;
}
const LifeGroup* LifeTable::find(std::int32_t number) const {
  const auto found = groups.find(number);
  return found == groups.end() ? nullptr : &found->second;
}

bool spent(const LifeGroup& group, std::size_t entry) {
  const LifeTool& tool = group.tools[entry];
  return tool.skipped || tool.used >= group.life;
}

LifeMark mark(const LifeGroup& group, std::size_t entry) {
  if (group.tools[entry].skipped) return LifeMark::skipped;
  if (spent(group, entry)) return LifeMark::expired;
  const Run run = run_of(group, entry);
  return group.current >= run.first && group.current < run.end ? LifeMark::in_use : LifeMark::available;
}

bool all_spent(const LifeGroup& group) {
  for (std::size_t i = 0; i < group.tools.size(); ++i)
    if (!spent(group, i)) return false;
  return true;
}

std::size_t choose(const LifeGroup& group) {
  const std::size_t start = std::min(group.current, group.tools.size() - 1);
  std::size_t entry = run_of(group, start).first;
  const std::size_t begin = entry;
  do {
    const Run run = run_of(group, entry);
    if (!run_spent(group, run)) {
      // Lives counted per entry: offsets that are spent are passed over as tools are.
      for (std::size_t i = run.first; i < run.end; ++i)
        if (!spent(group, i)) return i;
    }
    entry = run.end < group.tools.size() ? run.end : 0;
  } while (entry != begin);
  return run_of(group, group.tools.size() - 1).first;
}

std::size_t next_offset(const LifeGroup& group, std::size_t entry) {
  const Run run = run_of(group, entry);
  return entry + 1 < run.end ? entry + 1 : entry;
}

void use(LifeGroup& group, std::size_t entry, std::int64_t amount, SharedLife shared) {
  const Run run = shared == SharedLife::per_tool ? run_of(group, entry) : Run{entry, entry + 1};
  for (std::size_t i = run.first; i < run.end; ++i) group.tools[i].used += amount;
}

std::int64_t remaining(const LifeGroup& group) {
  if (group.tools.empty()) return 0;
  const LifeTool& tool = group.tools[std::min(group.current, group.tools.size() - 1)];
  return tool.skipped ? 0 : std::max<std::int64_t>(0, group.life - tool.used);
}

bool skip_current(LifeGroup& group) {
  if (group.tools.empty()) return false;
  const Run run = run_of(group, std::min(group.current, group.tools.size() - 1));
  for (std::size_t i = run.first; i < run.end; ++i) group.tools[i].skipped = true;
  return true;
}

void renew(LifeGroup& group) {
  for (LifeTool& tool : group.tools) {
    tool.used = 0;
    tool.skipped = false;
  }
  group.current = 0;
}

}  // namespace headstock::tools
