// G10 L3 … G11: tool life groups registered, changed and deleted by a program (0i-D 10.2.2).
#include <bit>

#include "interpreter/executor.hpp"
#include "interpreter/tool_life.hpp"

namespace headstock::interp::tool_life {
namespace {

using dialects::ToolLifeRules;
using tools::LifeGroup;
using tools::LifeUnit;

bool only(Executor& ex, std::uint32_t allowed) {
  const program::Block& b = ex.block;
  if (b.g_count != 0) return ex.alarm(AlarmReason::life_format, b.g[0], 'G');
  if (b.m_count != 0) return ex.alarm(AlarmReason::life_format, b.m[0], 'M');
  if (const std::uint32_t wrong = b.words & ~allowed; wrong != 0) {
    const char letter = static_cast<char>('A' + std::countr_zero(wrong));
    return ex.alarm(AlarmReason::life_format, b[letter].column, std::string(1, letter));
  }
  return true;
}

// P: a group number. @return 0 after an alarm.
std::int32_t group_number(Executor& ex) {
  const std::int64_t number = ex.whole('P', AlarmReason::life_group_number);
  if (number < 0) return 0;
  if (number < 1 || number > limits(ex).groups) {
    ex.alarm(AlarmReason::life_group_number, ex.block['P'].column, "P" + std::to_string(number));
    return 0;
  }
  return static_cast<std::int32_t>(number);
}

void report(Executor& ex, std::int32_t group, const char* what, double before, double after) {
  ex.report_change("tool_life/" + std::to_string(group) + "/" + what, before, after);
}

bool remove_line(Executor& ex) {
  if (!only(ex, program::letters("P"))) return false;
  if (!ex.block.has('P')) return ex.alarm(AlarmReason::life_no_p_l, 1, "P");
  const std::int32_t number = group_number(ex);
  if (number == 0) return false;
  if (ex.data.tool_life.groups.erase(number) != 0) report(ex, number, "registered", 1, 0);
  return true;
}

// P_ L_ [Q_]
bool group_line(Executor& ex) {
  const ToolLifeRules& rules = ex.dialect.life;
  if (!only(ex, program::letters("PLQ"))) return false;
  for (const char letter : {'P', 'L'})
    if (!ex.block.has(letter)) return ex.alarm(AlarmReason::life_no_p_l, 1, std::string(1, letter));
  const std::int32_t number = group_number(ex);
  if (number == 0) return false;
  LifeGroup group;
  group.unit = ex.data.bit(rules.by_time_parameter) ? LifeUnit::tenths : LifeUnit::uses;
  if (ex.block.has('Q')) {
    const std::int64_t q = ex.whole('Q', AlarmReason::life_format);
    if (q < 0) return false;
    if (q != 1 && q != 2) return ex.alarm(AlarmReason::life_format, ex.block['Q'].column, "Q");
    group.unit = q == 1 ? LifeUnit::uses : LifeUnit::tenths;
  }
  const std::int64_t life = ex.whole('L', AlarmReason::life_value);
  if (life < 0) return false;
  const bool in_minutes = group.unit == LifeUnit::tenths && !ex.data.bit(rules.tenths_word_parameter);
  group.life = life * (in_minutes ? kTenthsAMinute : 1);
  const std::int64_t most =
      group.unit == LifeUnit::uses ? rules.most_uses : rules.most_minutes * kTenthsAMinute;
  if (life == 0 || group.life > most) return ex.alarm(AlarmReason::life_value, ex.block['L'].column, "L");
  auto& groups = ex.data.tool_life.groups;
  if (!groups.contains(number) && static_cast<std::int64_t>(groups.size()) >= limits(ex).groups)
    return ex.alarm(AlarmReason::life_too_many_groups, ex.block['P'].column, "P");
  groups[number] = group;
  ex.life.input_group = number;
  report(
      ex, number, "life", 0,
      group.unit == LifeUnit::uses ? static_cast<double>(group.life) : static_cast<double>(group.life) / 10);
  return true;
}

// T_ [H_ D_]
bool tool_line(Executor& ex) {
  const bool changer = ex.dialect.life.form == ToolLifeRules::Form::changer;
  if (!only(ex, changer ? program::letters("THD") : program::letters("T"))) return false;
  if (!ex.block.has('T')) return ex.alarm(AlarmReason::life_no_t, 1, "T");
  if (ex.life.input_group == ToolLife::kNone)
    return ex.alarm(AlarmReason::life_no_p_l, ex.block['T'].column, "P");
  LifeGroup& group = ex.data.tool_life.groups[ex.life.input_group];
  if (group.tools.size() >= limits(ex).tools)
    return ex.alarm(AlarmReason::life_too_many_tools, ex.block['T'].column, "T");
  const std::int64_t t = ex.whole('T', AlarmReason::life_format);
  if (t < 0) return false;
  tools::LifeTool tool;
  const std::int64_t split = changer ? 1 : ex.offset_split();
  tool.tool = static_cast<std::int32_t>(t / split);
  tool.offset = static_cast<std::int32_t>(t % split);
  for (const char letter : {'H', 'D'}) {
    if (!ex.block.has(letter)) continue;
    const std::int64_t number = ex.whole(letter, AlarmReason::offset_number);
    if (number < 0) return false;
    if (number > static_cast<std::int64_t>(ex.dialect.tools.most_offsets))
      return ex.alarm(AlarmReason::offset_number, ex.block[letter].column, std::string(1, letter));
    (letter == 'H' ? tool.h : tool.d) = static_cast<std::int32_t>(number);
  }
  group.tools.push_back(tool);
  report(ex, ex.life.input_group, "tools", static_cast<double>(group.tools.size() - 1),
         static_cast<double>(group.tools.size()));
  return true;
}

bool line(Executor& ex) {
  if (ex.life.input == ToolLife::Input::remove) return remove_line(ex);
  return ex.block.has('P') || ex.block.has('L') || ex.block.has('Q') ? group_line(ex) : tool_line(ex);
}

bool finish(Executor& ex) {
  ex.life.input = ToolLife::Input::none;
  ex.life.input_group = ToolLife::kNone;
  return true;
}

}  // namespace

bool input(Executor& ex) {
  if (!is_on(ex)) return ex.alarm(AlarmReason::g_unavailable, ex.code_column, "G10 L3");
  std::int64_t form = 0;
  if (ex.block.has('P')) {
    form = ex.whole('P', AlarmReason::life_format);
    if (form < 0) return false;
    if (form != 1 && form != 2) return ex.alarm(AlarmReason::life_format, ex.block['P'].column, "P");
  }
  constexpr ToolLife::Input kForms[] = {ToolLife::Input::all, ToolLife::Input::change,
                                        ToolLife::Input::remove};
  ex.life.input = kForms[form];
  ex.life.input_group = ToolLife::kNone;
  // The groups that a running tool belongs to may be gone: its counting ends.
  ex.life.in_use = ex.life.chosen = ToolLife::kNone;
  if (form == 0) {
    for (const auto& [number, group] : ex.data.tool_life.groups) report(ex, number, "registered", 1, 0);
    ex.data.tool_life = {};
  }
  ex.data_input = {line, finish};
  return true;
}

}  // namespace headstock::interp::tool_life
