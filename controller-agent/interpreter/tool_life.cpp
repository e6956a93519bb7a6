#include "interpreter/tool_life.hpp"

#include <algorithm>
#include <cmath>

#include "interpreter/executor.hpp"

namespace headstock::interp::tool_life {
namespace {

using dialects::ToolLifeRules;
using tools::LifeGroup;
using tools::LifeUnit;

constexpr std::int32_t kToolChange = 6;
constexpr std::int64_t kReportEvery = 600;  // tenths: a power failure loses a minute of the count at most

const ToolLifeRules& rules_of(const Executor& ex) {
  return ex.dialect.life;
}

std::string name(std::int32_t group, std::string_view what) {
  return "tool_life/" + std::to_string(group) + "/" + std::string(what);
}
std::string name(std::int32_t group, std::string_view what, std::size_t entry) {
  return name(group, what) + "/" + std::to_string(entry);
}

tools::SharedLife shared(const Executor& ex) {
  return ex.data.bit(rules_of(ex).per_offset_parameter) ? tools::SharedLife::per_entry
                                                        : tools::SharedLife::per_tool;
}

bool was_commanded(const Executor& ex, std::int32_t group) {
  const auto& groups = ex.life.commanded;
  return std::find(groups.begin(), groups.end(), group) != groups.end();
}

void set_signal(Executor& ex, bool on) {
  if (ex.data.tool_life.change_due == on) return;
  ex.data.tool_life.change_due = on;
  ex.report_change("tool_life/change_due", on ? 0 : 1, on ? 1 : 0);
}

// The remaining life is compared whenever the tool in use has been counted.
void compare_with_notice(Executor& ex, std::int32_t number, const LifeGroup& group) {
  const ToolLifeRules& rules = rules_of(ex);
  std::int64_t left = tools::remaining(group);
  std::int64_t notice = 0;
  if (group.unit == LifeUnit::uses) {
    notice = static_cast<std::int64_t>(ex.data.parameter(rules.notice_uses_parameter));
  } else {
    const std::int64_t unit =
        ex.data.bit(rules.tenths_count_parameter) ? kTenthsAMinute / 10 : kTenthsAMinute;
    notice = std::llround(ex.data.parameter(rules.notice_time_parameter));
    left = (left + unit - 1) / unit;
  }
  const bool on = notice > 0 && (ex.data.bit(rules.notice_equal_parameter) ? left == notice : left <= notice);
  std::int32_t& shown = ex.data.tool_life.notice_group;
  const std::int32_t wanted = on ? number : shown == number ? 0 : shown;
  if (wanted == shown) return;
  ex.report_change("tool_life/notice_group", shown, wanted);
  shown = wanted;
}

void count_use(Executor& ex, std::int32_t number, LifeGroup& group, std::size_t entry) {
  const auto before = group.tools[entry].used;
  tools::use(group, entry, 1, shared(ex));
  ex.report_change(name(number, "used", entry), static_cast<double>(before),
                   static_cast<double>(group.tools[entry].used));
  compare_with_notice(ex, number, group);
}

void report_time(Executor& ex) {
  ToolLife& life = ex.life;
  if (life.unreported == 0) return;
  const LifeGroup* group = ex.data.tool_life.find(life.in_use);
  if (group != nullptr && life.in_use_entry < group->tools.size()) {
    const auto used = group->tools[life.in_use_entry].used;
    ex.report_change(name(life.in_use, "used", life.in_use_entry),
                     static_cast<double>(used - life.unreported) / 10, static_cast<double>(used) / 10);
  }
  life.unreported = 0;
}

void put_in_use(Executor& ex, std::int32_t group, std::size_t entry) {
  ToolLife& life = ex.life;
  report_time(ex);
  if (life.tenths_left > 0 && life.in_use > 0 && ex.data.bit(rules_of(ex).round_up_parameter)) {
    if (LifeGroup* before = ex.data.tool_life.find(life.in_use);
        before != nullptr && before->unit == LifeUnit::tenths && life.in_use_entry < before->tools.size())
      tools::use(*before, life.in_use_entry, 10, shared(ex));
  }
  life.tenths_left = 0;
  life.in_use = group;
  life.in_use_entry = entry;
}

void set_current(Executor& ex, std::int32_t number, LifeGroup& group, std::size_t entry) {
  if (group.current == entry) return;
  ex.report_change(name(number, "current"), static_cast<double>(group.current), static_cast<double>(entry));
  group.current = entry;
}

// The group, or the one that takes over from it. nullptr after an alarm.
LifeGroup* commanded_group(Executor& ex, std::int64_t& number, std::uint32_t column) {
  if (number > limits(ex).groups) {
    ex.alarm(AlarmReason::life_group_number, column, "T");
    return nullptr;
  }
  LifeGroup* group = ex.data.tool_life.find(static_cast<std::int32_t>(number));
  if (group == nullptr) {
    ex.alarm(AlarmReason::life_group_missing, column, "T");
    return nullptr;
  }
  if (group->tools.empty()) {
    ex.alarm(AlarmReason::life_data, column, "T");
    return nullptr;
  }
  if (ex.data.bit(rules_of(ex).next_group_parameter) && tools::all_spent(*group)) {
    for (auto& [other, candidate] : ex.data.tool_life.groups) {
      if (other <= number || candidate.tools.empty() || tools::all_spent(candidate)) continue;
      number = other;
      return &candidate;
    }
  }
  return group;
}

// Chooses the tool of a group. A group that this run has commanded already keeps its tool when uses are
// counted, and when time is counted and the tool has life left.
std::size_t choose(Executor& ex, std::int32_t number, LifeGroup& group, bool& again) {
  const std::size_t current = std::min(group.current, group.tools.size() - 1);
  const bool every = group.unit == LifeUnit::uses && ex.data.bit(rules_of(ex).every_use_parameter);
  again =
      was_commanded(ex, number) && !every && (group.unit == LifeUnit::uses || !tools::spent(group, current));
  const std::size_t entry = again ? current : tools::choose(group);
  set_current(ex, number, group, entry);
  return entry;
}

void remember(Executor& ex, std::int32_t number) {
  if (!was_commanded(ex, number)) ex.life.commanded.push_back(number);
}

// ---- turret

bool turret_t(Executor& ex, std::int64_t& value, std::uint32_t column) {
  const std::int64_t split = ex.offset_split();
  const std::int64_t all_nines = split - 1;
  const std::int64_t all_eights = all_nines / 9 * 8;
  const std::int64_t offset = value % split;
  std::int64_t number = value / split;
  ToolLife& life = ex.life;
  if (offset == all_eights) {
    if (life.in_use <= 0 || life.in_use != number) return ex.alarm(AlarmReason::life_wrong_t, column, "T");
    value = ex.data.tool_life.groups.at(life.in_use).tools[life.in_use_entry].tool * split;
    return true;
  }
  if (offset != all_nines) {
    put_in_use(ex, ToolLife::kNone, 0);
    return true;
  }
  LifeGroup* group = commanded_group(ex, number, column);
  if (group == nullptr) return false;
  const auto group_number = static_cast<std::int32_t>(number);
  bool again = false;
  std::size_t entry = choose(ex, group_number, *group, again);
  if (again) {
    entry = tools::next_offset(*group, entry);
    set_current(ex, group_number, *group, entry);
  }
  put_in_use(ex, group_number, entry);
  if (!again && group->unit == LifeUnit::uses) count_use(ex, group_number, *group, entry);
  // Lives counted per offset: each one that a run uses is a use.
  if (again && group->unit == LifeUnit::uses && shared(ex) == tools::SharedLife::per_entry)
    count_use(ex, group_number, *group, entry);
  remember(ex, group_number);
  value = group->tools[entry].tool * split + group->tools[entry].offset;
  return true;
}

// ---- changer

bool has_tool_change(const Executor& ex) {
  for (std::size_t i = 0; i < ex.block.m_count; ++i)
    if (ex.block.m[i].tenths == kToolChange * 10) return true;
  return false;
}

// M06: what T chose is in the spindle.
void change_to_chosen(Executor& ex) {
  ToolLife& life = ex.life;
  if (life.chosen == ToolLife::kNone) return;
  const std::int32_t number = std::max(life.chosen, ToolLife::kNone);
  put_in_use(ex, number, life.chosen_entry);
  life.chosen = ToolLife::kNone;
  LifeGroup* group = ex.data.tool_life.find(number);
  if (group == nullptr || life.in_use_entry >= group->tools.size()) return;
  const bool every = ex.data.bit(rules_of(ex).every_use_parameter);
  if (group->unit == LifeUnit::uses && (every || !was_commanded(ex, number)))
    count_use(ex, number, *group, life.in_use_entry);
  remember(ex, number);
}

bool changer_t(Executor& ex, std::int64_t& value, std::uint32_t column) {
  const ToolLifeRules& rules = rules_of(ex);
  ToolLife& life = ex.life;
  const auto ignore = static_cast<std::int64_t>(ex.data.parameter(rules.ignore_parameter));
  const bool beside_change = has_tool_change(ex);
  const bool counts_now = ex.data.bit(rules.count_in_change_parameter);
  const bool is_next = ex.data.bit(rules.next_in_change_parameter);
  if (beside_change && !counts_now && is_next) change_to_chosen(ex);
  if (value <= ignore) {
    // The tool that goes back to the magazine changes nothing; any other ends life management at its M06.
    if (!beside_change || counts_now || is_next) life.chosen = ToolLife::kOrdinary;
    return true;
  }
  std::int64_t number = value - ignore;
  if (beside_change && !counts_now && !is_next) {
    const bool same = life.in_use > 0 && life.in_use == number;
    if (!same && !ex.data.bit(rules.any_returned_parameter))
      return ex.alarm(AlarmReason::life_wrong_t, column, "T");
    const LifeGroup* group = ex.data.tool_life.find(life.in_use);
    if (group != nullptr && life.in_use_entry < group->tools.size())
      value = group->tools[life.in_use_entry].tool;
    return true;
  }
  LifeGroup* group = commanded_group(ex, number, column);
  if (group == nullptr) return false;
  bool again = false;
  life.chosen = static_cast<std::int32_t>(number);
  life.chosen_entry = choose(ex, life.chosen, *group, again);
  value = group->tools[life.chosen_entry].tool;
  return true;
}

bool is_restart(const Executor& ex, std::int32_t code) {
  const ToolLifeRules& rules = rules_of(ex);
  for (const std::string_view parameter : {rules.restart_parameter, rules.restart_large_parameter}) {
    const auto number = static_cast<std::int32_t>(ex.data.parameter(parameter));
    if (number != 0 && number == code) return true;
  }
  return false;
}

// Groups that count uses tell that they are spent at the end of a run or where the program says.
bool any_uses_spent(const Executor& ex) {
  for (const auto& [number, group] : ex.data.tool_life.groups)
    if (group.unit == LifeUnit::uses && !group.tools.empty() && tools::all_spent(group)) return true;
  return false;
}

}  // namespace

bool is_on(const Executor& ex) {
  return rules_of(ex).form != ToolLifeRules::Form::none && ex.data.bit(rules_of(ex).enable_parameter);
}

Limits limits(const Executor& ex) {
  const ToolLifeRules& rules = rules_of(ex);
  auto groups = static_cast<std::int64_t>(ex.data.parameter(rules.most_groups_parameter));
  if (groups <= 0 || groups > rules.most_groups) groups = rules.most_groups;
  if (rules.split_low_parameter.empty()) return {groups, rules.tools_in_group};
  const int split =
      (ex.data.bit(rules.split_low_parameter) ? 1 : 0) + (ex.data.bit(rules.split_high_parameter) ? 2 : 0);
  return {groups >> (3 - split), std::size_t{16} >> split};
}

bool take_t(Executor& ex, std::int64_t& value, std::uint32_t column) {
  if (!is_on(ex)) return true;
  return rules_of(ex).form == ToolLifeRules::Form::turret ? turret_t(ex, value, column)
                                                          : changer_t(ex, value, column);
}

bool take_m(Executor& ex, std::int32_t code, std::uint32_t column) {
  if (!is_on(ex)) return true;
  if (is_restart(ex, code)) {
    if (any_uses_spent(ex)) set_signal(ex, true);
    std::erase_if(ex.life.commanded, [&ex](std::int32_t number) {
      const LifeGroup* group = ex.data.tool_life.find(number);
      return group == nullptr || group->unit == LifeUnit::uses;
    });
    return true;
  }
  if (code != kToolChange || rules_of(ex).form != ToolLifeRules::Form::changer) return true;
  if (ex.data.bit(rules_of(ex).count_in_change_parameter) && !ex.block.has('T') &&
      !ex.data.bit(rules_of(ex).change_without_t_parameter))
    return ex.alarm(AlarmReason::life_no_t, column, "M6");
  // T beside M06 as the next group: the change was made before T chose.
  const bool made = ex.block.has('T') && ex.data.bit(rules_of(ex).next_in_change_parameter) &&
                    !ex.data.bit(rules_of(ex).count_in_change_parameter);
  if (!made) change_to_chosen(ex);
  return true;
}

bool take_offset(Executor& ex, char letter, std::int64_t& number, std::uint32_t column) {
  if (!is_on(ex) || rules_of(ex).form != ToolLifeRules::Form::changer) return true;
  const std::string_view parameter = letter == 'H' ? rules_of(ex).h_parameter : rules_of(ex).d_parameter;
  const auto chosen = static_cast<std::int64_t>(ex.data.parameter(parameter));
  constexpr std::int64_t kUsual = 99;
  if (number != (chosen != 0 ? chosen : kUsual)) return true;
  const LifeGroup* group = ex.data.tool_life.find(ex.life.in_use);
  if (group == nullptr || ex.life.in_use_entry >= group->tools.size())
    return ex.alarm(AlarmReason::life_not_in_use, column, std::string(1, letter));
  const tools::LifeTool& tool = group->tools[ex.life.in_use_entry];
  number = letter == 'H' ? tool.h : tool.d;
  return true;
}

void begin_run(Executor& ex) {
  ex.life.commanded.clear();
  ex.life.chosen = ToolLife::kNone;
}

void end_run(Executor& ex) {
  report_time(ex);
  if (is_on(ex) && any_uses_spent(ex)) set_signal(ex, true);
  ex.life.commanded.clear();
}

void leave(Executor& ex) {
  report_time(ex);
  ex.life.commanded.clear();
  ex.life.chosen = ToolLife::kNone;
  ex.life.input = ToolLife::Input::none;
}

bool stops_at_m99(Executor& ex) {
  if (!is_on(ex) || !ex.data.bit(rules_of(ex).stop_at_m99_parameter)) return false;
  if (any_uses_spent(ex)) set_signal(ex, true);
  ex.life.commanded.clear();
  return ex.data.tool_life.change_due;
}

void cut_for(Executor& ex, double seconds) {
  ToolLife& life = ex.life;
  if (life.in_use <= 0 || !is_on(ex)) return;
  LifeGroup* group = ex.data.tool_life.find(life.in_use);
  if (group == nullptr || group->unit != LifeUnit::tenths || life.in_use_entry >= group->tools.size()) return;
  life.tenths_left += seconds * 10;
  const std::int64_t interval = ex.data.bit(rules_of(ex).tenths_count_parameter) ? 1 : 10;
  const auto whole = static_cast<std::int64_t>(life.tenths_left / static_cast<double>(interval)) * interval;
  if (whole == 0) return;
  life.tenths_left -= static_cast<double>(whole);
  tools::use(*group, life.in_use_entry, whole, shared(ex));
  life.unreported += whole;
  if (life.unreported >= kReportEvery) report_time(ex);
  compare_with_notice(ex, life.in_use, *group);
  if (tools::all_spent(*group)) {
    report_time(ex);
    set_signal(ex, true);
  }
}

}  // namespace headstock::interp::tool_life
