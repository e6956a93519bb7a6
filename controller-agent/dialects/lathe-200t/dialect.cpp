// 200T/300T economical lathe control: component coordinates, named programs, no alarm numbers in the manual
// (ours: Axx).
#include <string>

#include "dialects/build.hpp"
#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"
#include "program/block.hpp"
#include "tables/gcodes_lathe_200t.hpp"

namespace headstock::interp::handlers {
bool reference_return(Executor& ex);
}

namespace headstock::dialects {
namespace {

using interp::Executor;

// G26 both axes, G27 X, G29 Z: rapid to where the last G50 stood (L2752).
bool start_point(Executor& ex) {
  const std::int16_t which = ex.code->tenths;
  machine::AxisVector target = ex.machine_now;
  std::uint32_t moved = 0;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    const char name = ex.axes[i].name;
    if ((which == 270 && name != 'X') || (which == 290 && name != 'Z')) continue;
    if (!ex.axes[i].has_start_point) {
      return ex.alarm(AlarmReason::no_start_point, ex.code_column, std::string(ex.code->name));
    }
    target[i] = ex.axes[i].start_point;
    moved |= 1u << i;
  }
  return moved == 0 || ex.emit_rapid_to_machine(target, moved, false);
}

// G58: as G50, but G53 takes it back; the start point stays (L3063). The shift lives in zero_local.
bool shift(Executor& ex) {
  std::vector<std::pair<double, double>> before;
  for (const auto& axis : ex.axes) before.emplace_back(axis.zero_shift, axis.zero_local);
  const auto starts = ex.axes;
  if (!interp::handlers::set_coordinates(ex)) return false;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    auto& axis = ex.axes[i];
    const double sum = axis.zero_shift + axis.zero_local;
    axis.zero_shift = before[i].first;
    axis.zero_local = sum - before[i].first;
    axis.start_point = starts[i].start_point;
    axis.has_start_point = starts[i].has_start_point;
    ex.update_zero(i);
  }
  return true;
}

bool cancel_shift(Executor& ex) {
  for (auto& axis : ex.axes) axis.zero_local = 0;
  ex.update_zeros();
  return true;
}

// Homing sets System to the reference point's parameter and the compensation: the offset is gone (3.5).
bool home(Executor& ex) {
  std::uint32_t named = 0;
  for (const char name : {'X', 'Z'}) {
    const char by = name == 'X' ? 'U' : 'W';
    const auto axis = ex.axis_named(name);
    if (axis && (ex.block.has(name) || ex.block.has(by))) named |= 1u << *axis;
  }
  if (named == 0) named = (1u << ex.axes.size()) - 1;
  if (!interp::handlers::reference_return(ex)) return false;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    if ((named >> i & 1u) == 0) continue;
    ex.axes[i].zero_shift = ex.axes[i].zero_local = 0;
    ex.update_zero(i);
  }
  return true;
}

constexpr OwnHandler kOwn[] = {{"start_point", Phase::action, start_point},
                               {"shift", Phase::action, shift},
                               {"cancel_shift", Phase::action, cancel_shift},
                               {"home", Phase::action, home}};

bool call_name(Executor& ex, std::string_view name, std::string_view rest, std::uint32_t column) {
  std::int64_t times = 1;
  if (const auto p = rest.find_first_of("Pp"); p != rest.npos) {
    times = 0;
    for (std::size_t i = p + 1; i < rest.size() && rest[i] >= '0' && rest[i] <= '9' && times < 100'000; ++i) {
      times = times * 10 + (rest[i] - '0');
    }
  }
  if (times > ex.dialect.calls.most_repeats) return ex.alarm(AlarmReason::call_count, column, "P");
  auto source = ex.programs == nullptr ? nullptr : ex.programs->open_name(name);
  if (source == nullptr) return ex.alarm(AlarmReason::program_not_found, column, std::string(name));
  return ex.call(std::move(source), 0, times, column);
}

// `M98 NT11 P10`: the lexer stops at the two letters of the name. @return false: not such a block, nothing
// was done.
bool statement(Executor& ex, std::string_view text, std::uint32_t column) {
  const bool calls = ex.block.m_count == 1 && ex.block.m[0].tenths == 980;
  if (!calls || text.size() < 2 || (text[0] != 'N' && text[0] != 'n')) return false;
  const std::string_view name = text.substr(1, text.find(' ') == text.npos ? text.npos : text.find(' ') - 1);
  call_name(ex, name, text.substr(1 + name.size()), column);
  return true;
}

}  // namespace

Dialect make_lathe_200t() {
  using program::letters;
  using R = AlarmReason;
  Dialect d;
  d.profile = "lathe-200t";
  set_alarm_codes(d, "A23",  // "line and reason" of the syntax check
                  {{R::arc_radius, "A04"},
                   {R::arc_no_center, "A18"},
                   {R::arc_r_too_small, "A18"},
                   {R::nesting, "A05"},
                   {R::end_of_record, "A05"},
                   {R::thread_lead, "A19"},
                   {R::no_start_point, "A20"},
                   {R::sequence_not_found, "A06"}});
  add_g_codes(d, tables::gcodes_lathe_200t, kOwn);
  for (bool& by_letter : d.incremental_letters) by_letter = true;
  d.m_rules = {{0, MAction::program_stop},  {1, MAction::unavailable},  {2, MAction::end_m02},
               {3, MAction::spindle_cw},    {4, MAction::spindle_ccw},  {5, MAction::spindle_stop},
               {9, MAction::machine_after}, {96, MAction::restart},     {98, MAction::call},
               {99, MAction::return_},      {901, MAction::unavailable}};  // M30 is an output pulse (L9581)
  d.numbers.decimal = Decimal::pocket;
  d.numbers.addresses = letters("DFHIJKLPQRSTUWXYZ");
  d.numbers.pointed = letters("DFIJKPQRUWXYZ");
  d.numbers.negative = letters("IJKRUWXYZ");
  d.arcs = {.tolerance_mm = 0.05, .closed_by_r_is_alarm = true};
  d.threads.inch_word = true;
  d.calls = {.nesting = 5, .l_repeats = false, .most_repeats = 65'533, .by_name = true};
  d.tools = {.lathe = true, .offset_digits = 2, .sign = -1, .most_offsets = 9};
  d.end_of_text = EndOfText::end;
  d.setting_ignores_offset = false;
  d.g28_alone_moves_all = true;
  d.statement = statement;
  return d;
}

}  // namespace headstock::dialects
