// 200T/300T economical lathe control: component coordinates, named programs, no alarm numbers in the manual
// (ours: Axx).
#include "dialects/build.hpp"
#include "dialects/lathe-200t/language.hpp"
#include "interpreter/executor.hpp"
#include "program/block.hpp"
#include "tables/gcodes_lathe_200t.hpp"

namespace headstock::dialects {
namespace lathe_200t {

// G04 X|U seconds, P milliseconds; alone it is not a command (L2697).
bool dwell(Executor& ex) {
  double seconds = 0;
  char letter = 0;
  for (const char unit : {'X', 'U', 'P'}) {
    if (!ex.block.has(unit)) continue;
    if (letter != 0) return ex.alarm(AlarmReason::dwell_words, ex.block[unit].column, std::string(1, unit));
    letter = unit;
    seconds = ex.block[unit].value() / (unit == 'P' ? 1'000 : 1);
  }
  if (letter == 0) return true;
  const bool in_range =
      letter == 'P' ? seconds >= 0.001 && seconds <= 200 : seconds >= 0.001 && seconds <= 100'000;
  if (!in_range) return ex.alarm(AlarmReason::value_range, ex.block[letter].column, std::string(1, letter));
  auto& pause = ex.emit<interp::Dwell>();
  pause.at = ex.at;
  pause.modal = ex.modal;
  pause.seconds = seconds;
  return true;
}

// G31 X Z F and L or K: as G01 until input L is active, or K is not (L2861, L9647).
bool skip(Executor& ex) {
  const bool by_l = ex.block.has('L'), by_k = ex.block.has('K');
  if (by_l == by_k) return ex.alarm(AlarmReason::no_data, ex.code_column, "G31 L K");
  const char letter = by_l ? 'L' : 'K';
  const std::int64_t port = ex.whole(letter, AlarmReason::value_range);
  if (port < 0) return false;
  if (!is_input(port))
    return ex.alarm(AlarmReason::value_range, ex.block[letter].column, std::string(1, letter));
  const machine::AxisVector from = ex.machine_now;
  std::uint32_t moved = 0;
  double feed = 0;
  interp::FeedUnit unit{};
  if (!ex.take_targets(moved) || moved == 0) return !ex.finished;
  if (!ex.cutting_feed(ex.path_to_targets(from, moved), feed, unit)) return false;
  auto& move = ex.emit<interp::Feed>();
  ex.fill_motion(move, moved);
  move.feed = feed;
  move.unit = unit;
  move.exact_stop = true;
  move.skip_signals = interp::kSkipInput;
  move.skip_input = static_cast<std::int16_t>(port);
  move.skip_level = by_l;
  ex.skip.machine = ex.machine_now;
  ex.skip.triggered = false;
  return true;
}

namespace {

constexpr OwnHandler kOwn[] = {{"dwell_200t", Phase::action, dwell},
                               {"modify_offset", Phase::action, modify_offset},
                               {"skip_200t", Phase::action, skip},
                               {"start_point", Phase::action, start_point},
                               {"home", Phase::action, home},
                               {"set_start", Phase::action, set_start},
                               {"clear_reference", Phase::action, clear_reference},
                               {"shift", Phase::action, shift},
                               {"cancel_shift", Phase::action, cancel_shift},
                               {"system_component", Phase::action, system_component},
                               {"modify_component", Phase::action, modify_component},
                               {"user_macro", Phase::setting, user_macro},
                               {"as_text", Phase::action, [](Executor& ex) {
                                  // G65, G170 and G171 are read before the lexer; here they stand behind
                                  // other words.
                                  return ex.alarm(AlarmReason::stand_alone, ex.code_column,
                                                  std::string(ex.code->name));
                                }}};

std::unique_ptr<interp::OwnLanguage> make_language(Executor& ex) {
  return std::make_unique<Language>(ex);
}

}  // namespace
}  // namespace lathe_200t

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
  add_g_codes(d, tables::gcodes_lathe_200t, lathe_200t::kOwn);
  for (bool& by_letter : d.incremental_letters) by_letter = true;
  d.m_rules = {{0, MAction::program_stop},  {1, MAction::own},          {2, MAction::end_m02},
               {3, MAction::spindle_cw},    {4, MAction::spindle_ccw},  {5, MAction::spindle_stop},
               {9, MAction::machine_after}, {96, MAction::restart},     {98, MAction::own},
               {99, MAction::return_},      {901, MAction::own}};  // M30 is an output pulse (L9581)
  d.numbers.decimal = Decimal::pocket;
  d.numbers.addresses = letters("DFHIJKLPQRSTUWXYZ");
  d.numbers.pointed = letters("DFIJKPQRUWXYZ");
  d.numbers.negative = letters("IJKRUWXYZ");
  d.arcs = {.tolerance_mm = 0.05, .closed_by_r_is_alarm = true};
  d.threads.inch_word = true;
  d.calls = {.nesting = 5, .l_repeats = false, .most_repeats = 65'533, .by_name = true};
  d.tools = {.lathe = true, .offset_digits = 2, .short_form = true, .sign = -1, .most_offsets = 9};
  d.end_of_text = EndOfText::end;
  d.sub_program_needs_return = true;
  d.setting_ignores_offset = false;
  d.g28_alone_moves_all = true;
  d.inner_slash_is_alarm = true;
  d.make_own = lathe_200t::make_language;
  return d;
}

}  // namespace headstock::dialects
