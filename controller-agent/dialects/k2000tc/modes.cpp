#include "dialects/k2000tc/modes.hpp"

#include <bit>
#include <cmath>
#include <string>

#include "dialects/k2000tc/language.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::dialects::k2000tc {
namespace {

// A code that must stand alone in its block, but for these words.
bool stands_alone(Executor& ex, std::uint32_t words, std::string_view alarm) {
  const auto& b = ex.block;
  if (b.g_count == 1 && b.m_count == 0 && (b.words & ~words) == 0) return true;
  return language(ex).raise(ex, alarm, ex.code_column, std::string(ex.code->name));
}

// Digits of P as axis numbers, first digit first; 0 where there is none. @return false when P is not of
// `count` digits.
bool axis_digits(std::int64_t p, int count, std::uint8_t* out) {
  for (int i = count - 1; i >= 0; --i) {
    out[i] = static_cast<std::uint8_t>(p % 10);
    p /= 10;
  }
  return p == 0;
}

bool coordinates_are_plain(const Executor& ex) {
  return !ex.transform.active() && !ex.polar.on;
}

}  // namespace

// G05 R E Q: P6457, P6459, P6453, stored at once (L5306).
bool modify_parameters(Executor& ex) {
  constexpr struct {
    char letter;
    std::string_view parameter;
    double least, most;
  } kWords[] = {{'R', "P6457", 0, 4}, {'E', "P6459", 0, 4}, {'Q', "P6453", 10, 179.999999}};
  if (!stands_alone(ex, program::letters("REQ"), "PS0009")) return false;
  for (const auto& word : kWords) {
    if (!ex.block.has(word.letter)) continue;
    const double value = ex.block[word.letter].value();
    if (value < word.least || value > word.most)
      return ex.alarm(AlarmReason::value_range, ex.block[word.letter].column, std::string(1, word.letter));
  }
  for (const auto& word : kWords) {
    if (!ex.block.has(word.letter)) continue;
    double& cell = ex.data.parameters[std::string(word.parameter)];
    const double before = cell;
    cell = ex.block[word.letter].value();
    if (before != cell) ex.report_change("parameter/" + std::string(word.parameter), before, cell);
  }
  return true;
}

// G07 IP0: the axis is interpolated but stands still; IP1 or leaving it out ends that (L3628).
bool hypothetical_axis(Executor& ex) {
  if (!stands_alone(ex, ex.axis_letters, "PS0009")) return false;
  Language& own = language(ex);
  std::uint32_t wanted = 0;
  for (std::uint32_t mask = ex.block.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    if (ex.block.word[letter].digits == 0) wanted |= 1u << static_cast<unsigned>(ex.axis_of[letter]);
  }
  if (wanted != 0 && ex.modal.g[7] != 400) return own.raise(ex, "PS0048", ex.code_column, "G07");
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    const bool was = (own.hypothetical >> i & 1u) != 0, is = (wanted >> i & 1u) != 0;
    if (is && !was) own.frozen[i] = ex.machine_now[i];
    if (was && !is) ex.set_axis_machine(i, own.frozen[i]);  // the absolute coordinate comes back (L3660)
  }
  own.hypothetical = wanted;
  ex.block.words &= ~ex.axis_letters;
  return true;
}

// G07.1 <rotary axis> r, and 0 to end it; alone in its block (L3519).
bool cylinder(Executor& ex) {
  Language& own = language(ex);
  if (!stands_alone(ex, ex.axis_letters, "PS0047")) return false;
  if (ex.modal.g[7] != 400) return own.raise(ex, "PS0048", ex.code_column, "G07.1");
  for (std::uint32_t mask = ex.block.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<std::size_t>(std::countr_zero(mask));
    if (!ex.axes[static_cast<std::size_t>(ex.axis_of[letter])].rotary)
      return own.raise(ex, "PS0108", ex.block.word[letter].column, "G07.1");
  }
  return interp::handlers::cylinder(ex);
}

// G12.1 Pij: linear axis i, rotary axis j; once on it is ignored (L3403).
bool polar_interpolation_on(Executor& ex) {
  if (!stands_alone(ex, program::letters("P"), "PS0009")) return false;
  if (ex.surface.now.kind == interp::SurfaceKind::polar) return true;
  std::int64_t p = 0;
  if (ex.block.has('P')) p = ex.whole('P', AlarmReason::value_range);
  if (p < 0) return false;
  std::uint8_t axis[2] = {};
  const bool two = axis_digits(p, 2, axis);
  const auto index = [&ex, two](std::uint8_t number) {
    return two && number >= 1 && number <= ex.axes.size() ? static_cast<int>(number) - 1 : -1;
  };
  return interp::handlers::enter_polar(ex, index(axis[0]), index(axis[1]));
}

bool polar_interpolation_off(Executor& ex) {
  const bool by_itself = ex.block.g_count == 0;  // a power-on code
  return (by_itself || stands_alone(ex, 0, "PS0009")) && interp::handlers::polar_interpolation_off(ex);
}

// G07.2 Pij NF NP: the spindle, as rotary axis j, follows linear axis i by lead NF; alone it ends (L4129).
bool spindle_thread(Executor& ex) {
  Language& own = language(ex);
  if (!stands_alone(ex, program::letters("P"), "PS0009")) return false;
  if (!ex.block.has('P')) {
    own.thread.on = false;
    return true;
  }
  const std::int64_t p = ex.whole('P', AlarmReason::value_range);
  if (p < 0) return false;
  std::uint8_t axis[2] = {};
  const bool two = axis_digits(p, 2, axis);
  const auto fits = [&ex](std::uint8_t number, bool rotary) {
    return number >= 1 && number <= ex.axes.size() && ex.axes[number - 1u].rotary == rotary;
  };
  if (!two || !fits(axis[0], false) || !fits(axis[1], true))
    return own.raise(ex, "PS0120", ex.block['P'].column, "P");
  if (!ex.block.has_marked('F')) return ex.alarm(AlarmReason::thread_lead, ex.code_column, "NF");
  own.thread.on = true;
  own.thread.linear = axis[0] - 1u;
  own.thread.spindle = axis[1] - 1u;
  own.thread.lead_mm = ex.block.marked_at('F').value() * ex.unit_mm;
  own.thread.reversed = ex.block.has_marked('P') && ex.block.marked_at('P').digits != 0;
  if (own.thread.lead_mm < 0) return ex.alarm(AlarmReason::thread_lead, ex.block.marked_at('F').column, "NF");
  // The control stops the spindle by itself before it becomes an axis (L4190).
  ex.spindle_direction = interp::SpindleDirection::stop;
  ex.emit_spindle();
  auto& sent = ex.emit<interp::MCode>();
  sent.at = ex.at;
  sent.modal = ex.modal;
  sent.code = 5;
  return true;
}

// G10.9 X0 radius, X1 diameter, until reset (L7360). The offset pages keep the machine's own meaning.
bool diameter_or_radius(Executor& ex) {
  if (!stands_alone(ex, program::letters("X"), "PS0009")) return false;
  const auto x = ex.axis_named('X');
  if (!x || !ex.block.has('X')) return ex.alarm(AlarmReason::illegal_address, ex.code_column, "G10.9 X");
  language(ex).set_diameter(ex, *x, ex.block['X'].digits != 0);
  ex.block.words &= ~program::letter_bit('X');
  return true;
}

// G53: machine coordinates; the tool's offset is gone until the next T (L5646).
bool machine_move(Executor& ex) {
  if (!interp::handlers::machine_move(ex)) return false;
  if ((ex.block.words & ex.axis_letters) != 0) language(ex).cancel_tool_offset(ex);
  return true;
}

// G153 IP NF: as G53, at feed NF, which holds for G153 blocks that follow each other (L5675).
bool fast_machine_move(Executor& ex) {
  Language& own = language(ex);
  if (ex.block.has_marked('F')) own.fast_feed = ex.block.marked_at('F').value() * ex.unit_mm;
  if (!(own.fast_feed > 0)) return ex.alarm(AlarmReason::feed_missing, ex.code_column, "NF");
  if (!interp::handlers::machine_move(ex)) return false;
  if ((ex.block.words & ex.axis_letters) == 0) return true;
  // The rapid just made, at a feed of its own.
  interp::Operation& made = ex.queue.size() > ex.queue_head ? ex.queue.back() : *ex.out;
  const auto* rapid = std::get_if<interp::Rapid>(&made);
  if (rapid == nullptr) return true;
  interp::Feed motion;
  static_cast<interp::Motion&>(motion) = *rapid;
  motion.feed = own.fast_feed;
  made = motion;
  own.cancel_tool_offset(ex);
  return true;
}

// G54.9 Pijk: axes i, j, k are Xp, Yp, Zp; P0 or nothing: 1, 3, 2 (L6100).
bool assign_axes(Executor& ex) {
  Language& own = language(ex);
  if (!stands_alone(ex, program::letters("P"), "PS0009")) return false;
  if (ex.modal.g[7] != 400) return own.raise(ex, "PS0040", ex.code_column, "G54.9");
  if (!coordinates_are_plain(ex)) return ex.alarm(AlarmReason::g_not_now, ex.code_column, "G54.9");
  std::int64_t p = 0;
  if (ex.block.has('P')) p = ex.whole('P', AlarmReason::value_range);
  if (p < 0) return false;
  std::uint8_t axis[3] = {};
  const bool three = axis_digits(p, 3, axis);
  const bool different = axis[0] != axis[1] && axis[1] != axis[2] && axis[0] != axis[2];
  for (const std::uint8_t number : axis) {
    if (p != 0 && (number < 1 || number > ex.axes.size() || !different || !three))
      return ex.alarm(AlarmReason::arc_plane, ex.block['P'].column, "P" + std::to_string(p));
  }
  ex.roles_given = p != 0;
  ex.given_roles.fill(0);
  for (std::size_t i = 0; p != 0 && i < 3; ++i)
    ex.given_roles[axis[i] - 1u] = static_cast<std::int8_t>(i + 1);
  ex.select_plane(ex.plane);
  return true;
}

namespace {

bool mirror_x(Executor& ex, bool on) {
  const auto x = ex.axis_named('X');
  if (!x) return ex.alarm(AlarmReason::illegal_g, ex.code_column, std::string(ex.code->name));
  if (ex.transform.rotated || ex.transform.scaled != 0)
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, std::string(ex.code->name));
  const std::uint32_t bit = 1u << *x;
  ex.transform.mirrored = on ? ex.transform.mirrored | bit : ex.transform.mirrored & ~bit;
  ex.transform.mirror_at[*x] = 0;
  ex.follow_transform();
  return true;
}

}  // namespace

// G68: X runs the other way and the absolute X changes its sign; needs MIRG (L15017).
bool mirror_x_on(Executor& ex) {
  if (!ex.data.bit("P0003.5")) return ex.alarm(AlarmReason::illegal_g, ex.code_column, "G68");
  return mirror_x(ex, true);
}

bool mirror_x_off(Executor& ex) {
  return mirror_x(ex, false);
}

// G04 X|U seconds, P milliseconds. An X before the G04 has been read as a length: its least increments count
// as milliseconds (L7236).
bool dwell(Executor& ex) {
  const auto& b = ex.block;
  auto& pause = ex.emit<interp::Dwell>();
  pause.at = ex.at;
  pause.modal = ex.modal;
  if (ex.cycle.watch == nullptr) ex.hold_look_ahead();  // L5382; a profile is read to its end at once
  for (const char letter : {'X', 'U', 'P'}) {
    if (!b.has(letter)) continue;
    const program::Word& word = b[letter];
    double seconds = word.value() / 1'000;
    if (letter != 'P' && (word.point || ex.pocket)) {
      const bool as_length = word.column < ex.code_column;
      seconds = as_length ? static_cast<double>(word.nano() / ex.linear_increment) / 1'000 : word.value();
    }
    if (seconds < 0 || seconds > 99'999.999)
      return ex.alarm(AlarmReason::value_range, word.column, std::string(1, letter));
    pause.seconds = seconds;
    return true;
  }
  return true;  // alone: an exact stop
}

// ---- what Language keeps for these modes

void Language::set_diameter(Executor& ex, std::size_t axis, bool diameter) {
  auto& a = ex.axes[axis];
  if (a.page_diameter == 0) a.page_diameter = a.diameter;
  a.diameter = diameter ? 0.5 : 1;
  ex.set_units(ex.modal.inch);
}

void Language::cancel_tool_offset(Executor& ex) {
  for (std::size_t i = 0; i < ex.axes.size(); ++i) interp::tool_offset::drop(ex, i);
  ex.modal.offset = 0;
}

bool Language::cartesian_axes(const Executor& ex, std::uint8_t (&axes)[3]) const {
  constexpr char kNames[] = {'X', 'Y', 'Z'};
  int found = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    axes[i] = kNoAxis;
    for (std::size_t k = 0; k < ex.axes.size(); ++k) {
      const bool is =
          ex.roles_given ? ex.given_roles[k] == static_cast<int>(i) + 1 : ex.axes[k].name == kNames[i];
      if (is) axes[i] = static_cast<std::uint8_t>(k);
    }
    found += axes[i] == kNoAxis ? 0 : 1;
  }
  return found >= 2;
}

void Language::moved(Executor& ex, interp::Motion& motion) {
  for (std::uint32_t left = hypothetical; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    if (i < ex.axes.size()) motion.end_machine[i] = frozen[i];
  }
}

// Turns of the spindle after `way` of a move of `distance`: leads that differ change evenly along the way,
// and a lead of 0 means no turning (L4170).
double SpindleThread::turns(double way, double distance, double lead_end) const {
  if (lead_mm > 0 && lead_end > 0) {
    if (lead_mm == lead_end) return way / lead_mm;
    const double slope = (lead_end - lead_mm) / distance;
    return std::log1p(slope * way / lead_mm) / slope;
  }
  const double from = lead_mm > 0 ? 1 / lead_mm : 0, to = lead_end > 0 ? 1 / lead_end : 0;
  return from * way + (to - from) * way * way / (2 * distance);
}

}  // namespace headstock::dialects::k2000tc
