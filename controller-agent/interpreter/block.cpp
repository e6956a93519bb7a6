// One block: checks, then everything it commands in the controllers' order.
#include <bit>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp {
namespace {

using program::letters;

char lowest_letter(std::uint32_t mask) {
  return static_cast<char>('A' + std::countr_zero(mask));
}

// G04 G10 G28 G29 G30 G50 (G92) G53.
constexpr bool refuses_t(std::int16_t tenths) {
  return tenths == 40 || tenths == 100 || tenths == 280 || tenths == 290 || tenths == 300 || tenths == 500 ||
         tenths == 920 || tenths == 530;
}

constexpr std::uint32_t kFeedSpindleTool = letters("FST");

}  // namespace

bool Executor::execute() {
  ++at.block;
  at.part = 0;
  if (macros != nullptr) {
    motions_before = motions;
    move_calls = !frames.back().macro.modal_calls.empty();
    bool taken = false;
    if ((block.g_count | block.m_count) != 0 || macros->calls_by_code) {
      if (!take_calls(taken)) return false;
      if (taken) return true;
    }
  }
  const bool good = execute_words();
  if (macros == nullptr) return good;
  if (!good) {
    sub_call = nullptr;
    return false;
  }
  if (sub_call != nullptr && !run_pending_call()) return false;
  if (!finished) remember_modal_values();
  return true;
}

bool Executor::execute_words() {
  // Data of G10 … up to G11. A lone G11 is an ordinary code.
  if (data_input.line != nullptr && !(block.g_count == 1 && block.g[0].tenths == 110))
    return check_words() && data_input.line(*this);
  if (!check_words() || !take_codes()) return false;
  if (block.g_count != 0 && (pipeline.line_is_open() || drawing_block()) && !drawing_allows_codes())
    return false;
  if (block.m_count != 0 && !calls_fit_cycle()) return false;
  if (surface.now.kind != SurfaceKind::none && !surface_allows()) return false;
  if (dialect.compensation.by_d && block.has('D') && !take_d()) return false;
  if (length_sign != 0) tool_offset::follow_changes(*this);
  if (setting_count != 0 && !run_settings()) return false;
  if (switches.origin == ProgramOrigin::mdi && data.bit(dialect.modes.mdi_form_parameter))
    incremental = !data.bit(dialect.modes.mdi_absolute_parameter);
  if (!dialect.tools.lathe && block.has('H') && !length_in_block() && !tool_offset::take_h(*this))
    return false;
  if ((block.words & kFeedSpindleTool) != 0) {
    if (block.has('F') && !take_feed()) return false;
    if (block.has('S') && !take_spindle()) return false;
    if (block.has('T') && !take_tool()) return false;
  }
  if (auxiliary_letter != 0 && block.has(auxiliary_letter) && !take_second_auxiliary(auxiliary_letter))
    return false;
  if (block.m_count != 0 && !run_m_codes(false)) return false;
  if (spindle_changed) emit_spindle();
  if (((block.words & dialect.corner_words) | block.marked) != 0 && !take_corner_words()) return false;

  if (cycle.rigid_next && !rigid_tap_follows()) return false;
  // A move of an axis that the machine does not have must not be left out silently.
  if (const std::uint32_t wrong = block.words & axis_like & ~axis_letters;
      wrong != 0 && (action == nullptr || !action->cycle) && !is_h_block()) {
    const char letter = lowest_letter(wrong);
    return alarm(AlarmReason::illegal_address, block[letter].column, std::string(1, letter));
  }
  if (action != nullptr) {
    code = action;
    code_column = action_column;
    if (!action->handler(*this)) return false;
  } else if (cycle.hole.code != nullptr) {
    code = cycle.hole.code;
    if (!code->handler(*this)) return false;
  } else if (((block.words & axis_letters) | pending_axes) != 0) {
    code = motion_code;
    if (motion_code->phase == Phase::unavailable) {
      return alarm(AlarmReason::g_unavailable, 0, std::string(motion_code->name));
    }
    const bool offset_only = (block.words & (axis_letters | letters("IJKR"))) == 0;
    if (!(offset_only ? tool_offset::move_alone(*this) : motion_code->handler(*this))) return false;
  } else if (block.has('I') && motion_code->handler != nullptr) {
    // A full circle needs no axis word; a straight move ignores the word.
    code = motion_code;
    if (!motion_code->handler(*this)) return false;
  } else if (((block.words & letters("JKR")) != 0) && motion_code->handler != nullptr) {
    code = motion_code;
    if (!motion_code->handler(*this)) return false;
  }
  if (cycle.starts_cycle) {  // the cycle's moves come first
    cycle.starts_cycle = false;
    if (block.m_count != 0) cycle.deferred = std::make_unique<program::Block>(block);
    return true;
  }
  if (block.m_count != 0 && !(run_m_codes(true) && run_program_flow())) return false;
  if (move_calls && motions != motions_before && !finished) return call_modal();
  return true;
}

// M98 and M99 beside a turning cycle, on controls that have a number for it (218T 165).
bool Executor::calls_fit_cycle() {
  if (dialect.alarm_code(AlarmReason::call_with_cycle) == dialect.alarm_code(AlarmReason::compensation_call))
    return true;
  const bool box = action == nullptr && motion_code->cycle && (block.words & axis_letters) != 0;
  if (!box && (action == nullptr || !action->cycle)) return true;
  for (std::size_t i = 0; i < block.m_count; ++i) {
    const dialects::MAction what = dialect.m_action(block.m[i].tenths / 10);
    if (what == dialects::MAction::call || what == dialects::MAction::return_)
      return alarm(AlarmReason::call_with_cycle, block.m[i], 'M');
  }
  return true;
}

// After M29 comes the tapping cycle, with no move before it (0i-D PS0204, GSK 2000TC 195).
bool Executor::rigid_tap_follows() {
  const GCode* next = action != nullptr ? action : cycle.hole.code != nullptr ? cycle.hole.code : motion_code;
  const bool moves = (block.words & axis_letters) != 0;
  if (!moves || next->cycle) return true;
  return alarm(AlarmReason::rigid_tap_move, 0, "M29");
}

bool Executor::length_in_block() const {
  for (std::size_t i = 0; i < setting_count; ++i) {
    if (settings[i]->handler == handlers::length_offset) return true;
  }
  return false;
}

bool Executor::run_deferred() {
  if (cycle.deferred == nullptr) return true;
  block = *cycle.deferred;
  cycle.deferred.reset();
  return run_m_codes(true) && run_program_flow();
}

bool Executor::check_words() {
  const program::Block& b = block;
  if (const std::uint32_t wrong = b.words & ~legal; wrong != 0) {
    const char letter = lowest_letter(wrong);
    return alarm(AlarmReason::illegal_address, b[letter].column, std::string(1, letter));
  }
  if (const std::uint32_t wrong = b.pointed & ~may_point; wrong != 0) {
    const char letter = lowest_letter(wrong);
    return alarm(AlarmReason::decimal_point, b[letter].column, std::string(1, letter));
  }
  const std::uint32_t signed_operands = is_h_block() ? letters("PQR") : 0;
  if (const std::uint32_t wrong = b.negative & ~(may_minus | signed_operands); wrong != 0) {
    const char letter = lowest_letter(wrong);
    return alarm(AlarmReason::minus_sign, b[letter].column, std::string(1, letter));
  }
  if (b.repeated == 0 && b.inner_slash == 0) return true;
  const double refused_by_itself = dialect.repeated_words == dialects::Repeated::alarm ? 1 : 0;
  const bool refused = data.parameter(dialect.repeated_alarm_parameter, refused_by_itself) != 0;
  if (b.repeated != 0 && refused && !switches.lenient) {
    if (const std::uint32_t wrong = b.repeated & ~dialect.may_repeat; wrong != 0) {
      const char letter = lowest_letter(wrong);
      return alarm(AlarmReason::duplicate_word, b[letter].column, std::string(1, letter));
    }
  }
  if (b.inner_slash != 0 && dialect.inner_slash_is_alarm)
    return alarm(AlarmReason::slash_position, b.inner_slash);
  return true;
}

// G65 H…: operations on variables (GSK).
bool Executor::is_h_block() const {
  return macros != nullptr && macros->rules.h_codes && block.g_count != 0 && block.g[0].tenths == 650 &&
         (block.has('H') || !macros->rules.macro_calls);
}

// Sorts the G codes by what they are; the last of a group counts.
bool Executor::take_codes() {
  setting_count = 0;
  action = nullptr;
  exact_stop_once = false;
  pending_axes = 0;
  const GCode* new_motion = nullptr;
  const GCode* new_hole = nullptr;
  const GCode* cycle_code = nullptr;  // of G70-G76
  std::uint32_t groups = 0;
  for (std::size_t i = 0; i < block.g_count; ++i) {
    const program::Code& written = block.g[i];
    const GCode* row = table->find(written.tenths);
    if (row == nullptr) return alarm(AlarmReason::illegal_g, written, 'G');
    for (const Codes& absent : absent_codes) {
      if (row->tenths >= absent.first && row->tenths <= absent.last)
        return alarm(AlarmReason::illegal_g, written, 'G');
    }
    if (row->group != 0) {
      const std::uint32_t bit = 1u << row->group;
      if ((groups & bit) != 0 && dialect.same_group == dialects::Repeated::alarm && !switches.lenient) {
        return alarm(AlarmReason::g_same_group, written, 'G');
      }
      groups |= bit;
    }
    if (row->cycle && row->phase == Phase::action) {
      if (cycle_code != nullptr && cycle_code != row) return alarm(AlarmReason::two_cycles, written, 'G');
      cycle_code = row;
    }
    switch (row->phase) {
      case Phase::unavailable:
        return alarm(AlarmReason::g_unavailable, written, 'G');
      case Phase::setting:
        settings[setting_count] = row;
        setting_columns[setting_count++] = written.column;
        break;
      case Phase::modifier:
        exact_stop_once = true;
        break;
      case Phase::action:
        action = row;
        action_column = written.column;
        break;
      case Phase::motion:
        new_motion = row;
        new_hole = nullptr;  // of a motion and a hole cycle in one block the later one counts
        break;
      case Phase::hole:
        new_hole = row;
        break;
    }
    if (row->group != 0) modal.g[row->group] = row->tenths;
  }
  if (action != nullptr && new_motion != nullptr && dialect.one_shot_with_motion_is_alarm &&
      !switches.lenient) {
    return alarm(AlarmReason::g_one_shot_and_motion, action_column, std::string(action->name));
  }
  if (action != nullptr && block.has('T') && dialect.t_refused_with_actions && !action->cycle &&
      refuses_t(action->tenths)) {
    return alarm(AlarmReason::t_not_allowed, block['T'].column, std::string(action->name));
  }
  if (new_motion != nullptr) motion_code = new_motion;
  if (new_motion != nullptr || action != nullptr || new_hole != nullptr) {
    cycle.on_codes(new_motion, action, new_hole);
    if (new_hole != nullptr && !dialect.hole_clamp_parameter.empty())
      cycle.clamp_m = static_cast<std::int32_t>(data.parameter(dialect.hole_clamp_parameter));
    if (cycle.hole_ended != nullptr) {  // a code of group 01 is a G80 too
      modal.g[cycle.hole_ended->group] = 800;
      cycle.hole_ended = nullptr;
    }
  }
  return true;
}

bool Executor::run_settings() {
  for (std::size_t i = 0; i < setting_count; ++i) {
    code = settings[i];
    code_column = setting_columns[i];
    if (code->handler != nullptr && !code->handler(*this)) return false;
  }
  return true;
}

bool Executor::run_m_codes(bool after_motion) {
  using dialects::MAction;
  if (!after_motion) {
    const std::size_t most = data.bit(dialect.more_m_parameter) ? 3 : dialect.most_m_codes;
    if (block.m_count > most && !switches.lenient) {
      return alarm(AlarmReason::too_many_m, block.m[most], 'M');
    }
    if (block.m_count > 1 && most > 1 && dialect.modes.flow_codes_alone && !switches.lenient) {
      for (std::size_t i = 0; i < block.m_count; ++i) {
        switch (dialect.m_action(block.m[i].tenths / 10)) {
          case MAction::program_stop:
          case MAction::optional_stop:
          case MAction::end_m02:
          case MAction::end_m30:
          case MAction::call:
          case MAction::return_:
            return alarm(AlarmReason::m_combination, block.m[i], 'M');
          default:
            break;
        }
      }
    }
    if (block.m_pointed && !switches.lenient)
      return alarm(AlarmReason::decimal_point, block.m[0].column, "M");
  }
  for (std::size_t i = 0; i < block.m_count; ++i) {
    if (block.m[i].tenths < 0 || block.m[i].tenths % 10 != 0)
      return alarm(AlarmReason::decimal_point, block.m[i].column, "M");
    const std::int32_t number = block.m[i].tenths / 10;
    const MAction what = dialect.m_action(number);
    bool is_after = false;
    switch (what) {
      case MAction::spindle_cw:
      case MAction::spindle_ccw:
        if (!after_motion) {
          const auto opposite = what == MAction::spindle_cw ? SpindleDirection::ccw : SpindleDirection::cw;
          if (dialect.reversal_needs_stop && spindle_direction == opposite)
            return alarm(AlarmReason::spindle_reversed, block.m[i], 'M');
          spindle_direction = what == MAction::spindle_cw ? SpindleDirection::cw : SpindleDirection::ccw;
          spindle_changed = true;
        }
        break;
      case MAction::spindle_stop:
        is_after = true;
        if (after_motion) {
          spindle_direction = SpindleDirection::stop;
          emit_spindle();
        }
        break;
      case MAction::rigid_tapping:
        // G84 and G88 as modal codes of group 01 (GSK 2000TC 196).
        if (!after_motion && motion_code->cycle &&
            (motion_code->tenths == 840 || motion_code->tenths == 880) &&
            modal.g[motion_code->group] == motion_code->tenths)
          return alarm(AlarmReason::rigid_tap_again, block.m[i], 'M');
        cycle.rigid_next = true;
        break;
      case MAction::machine:
        cycle.rigid_next = cycle.rigid_next || number == rigid_m;
        cycle.small_holes = cycle.small_holes || number == small_hole_m;
        break;
      case MAction::machine_after:
        is_after = true;
        break;
      case MAction::unavailable:
        return alarm(AlarmReason::m_unavailable, block.m[i], 'M');
      default:
        continue;  // program flow, not sent to the machine
    }
    if (is_after != after_motion) continue;
    if (number >= 13 && number <= 15) cycle.driven_m = number == 15 ? 0 : number;
    if (!tool_life::take_m(*this, number, block.m[i].column)) return false;
    if (cycle.hole.code != nullptr && number != 0 && number == cycle.clamp_m) {
      cycle.hole.clamp = true;  // goes out when the hole's position is reached
      continue;
    }
    if (spindle_changed) emit_spindle();
    auto& sent = emit<MCode>();
    sent.at = at;
    sent.modal = modal;
    sent.code = number;
    sent.after_motion = is_after;
    sent.counts_part = number == part_count_m;
    if (look_ahead.holds(number)) hold_look_ahead();
  }
  return true;
}

bool Executor::run_program_flow() {
  using dialects::MAction;
  for (std::size_t i = 0; i < block.m_count; ++i) {
    const std::uint32_t column = block.m[i].column;
    switch (dialect.m_action(block.m[i].tenths / 10)) {
      case MAction::program_stop:
      case MAction::optional_stop: {
        const bool optional = dialect.m_action(block.m[i].tenths / 10) == MAction::optional_stop;
        if (optional && !switches.optional_stop) break;
        auto& stop = emit<Stop>();
        stop.at = at;
        stop.modal = modal;
        stop.optional = optional;
        if (dialect.look_ahead.stops) hold_look_ahead();
        break;
      }
      case MAction::end_m02:
      case MAction::end_m30: {
        const bool m30 = dialect.m_action(block.m[i].tenths / 10) == MAction::end_m30;
        const bool counts = (m30 || dialect.m02_counts_part) && !data.bit(dialect.no_count_parameter);
        tool_life::end_run(*this);
        return finish(m30 ? EndReason::m30 : EndReason::m02, counts);
      }
      case MAction::call: {
        if (cycle.hole.code != nullptr && (block.words & axis_letters) != 0 && macros != nullptr)
          return alarm(AlarmReason::call_in_hole_cycle, column, "M98");
        if (dialect.compensation.calls_refused && pipeline.side() != 0)
          return alarm(AlarmReason::compensation_call, column, "M98");
        if (dialect.calls.by_name) return alarm(AlarmReason::call_without_p, column, "M98");
        std::int64_t from_sequence = -1;
        if (macros != nullptr && block.has('Q') && data.bit(macros->rules.sequence_call_parameter)) {
          from_sequence = whole('Q', AlarmReason::sequence_not_found);
          if (from_sequence < 0) return false;
        }
        std::int64_t p = frames.back().number;  // M98 Q: in this program
        if (from_sequence < 0 || block.has('P')) {
          if (!block.has('P')) return alarm(AlarmReason::call_without_p, column, "M98");
          p = whole('P', AlarmReason::call_p_value);
          if (p < 0) return false;
        }
        std::int64_t times = p > 9'999 ? p / 10'000 : 1;
        if (block.has('L') && dialect.calls.l_repeats) {
          if (p > 9'999) return alarm(AlarmReason::call_count, block['L'].column, "L");
          times = whole('L', AlarmReason::call_count);
          if (times < 0) return false;
        }
        if (times > dialect.calls.most_repeats) return alarm(AlarmReason::call_count, block['P'].column, "P");
        const auto number = static_cast<std::uint32_t>(p % 10'000);
        const std::uint32_t at_column = block.has('P') ? block['P'].column : column;
        if (!call(programs == nullptr ? nullptr : programs->open_number(number), number, times, at_column))
          return false;
        if (from_sequence < 0 || times <= 0) return true;
        frames.back().macro.start_sequence = from_sequence;
        return begin_search(from_sequence, block['Q'].column, AlarmReason::sequence_not_found);
      }
      case MAction::return_: {
        if (dialect.compensation.calls_refused && pipeline.side() != 0 && frames.size() > 1)
          return alarm(AlarmReason::compensation_call, column, "M99");
        std::int64_t sequence = -1;
        if (macros != nullptr && frames.back().macro.kind == CallKind::modal &&
            ((block.words & ~letters("PL")) != 0 || block.g_count != 0))
          return alarm(AlarmReason::macro_m99_with_words, column, "M99");
        if (block.has('P')) {
          sequence = whole('P', AlarmReason::sequence_not_found);
          if (sequence < 0) return false;
        }
        if (move_calls && motions != motions_before) {  // the call first, then the return (0i-D L18869)
          frames.back().macro.returns_after_call = true;
          frames.back().macro.returns_to = sequence;
          break;
        }
        if (frames.size() > 1) return return_from_sub(sequence, column);
        const bool stops = tool_life::stops_at_m99(*this);
        if (stops) {
          auto& stop = emit<Stop>();
          stop.at = at;
          stop.modal = modal;
        }
        if (sequence >= 0) return jump_to_sequence(sequence, column);
        return finish(EndReason::m99_main, dialect.m99_main_counts_part);
      }
      case MAction::restart:
        return finish(EndReason::m99_main, dialect.m99_main_counts_part);
      case MAction::own:
        if (own && !own->m_code(*this, block.m[i])) return false;
        break;
      default:
        break;
    }
  }
  return true;
}

}  // namespace headstock::interp
