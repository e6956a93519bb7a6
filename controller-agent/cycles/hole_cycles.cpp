// Hole cycles: which code does what on which control, their words, and how their moves become operations.
#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <utility>

#include "cycles/handlers.hpp"
#include "cycles/holes.hpp"
#include "cycles/thread_words.hpp"
#include "cycles/turning_run.hpp"

namespace headstock::cycles {
namespace {

using interp::Executor;
using interp::SpindleDirection;

struct HoleCode {
  std::int16_t tenths;
  const char* name;
  HoleKind kind;
  char axis = 0;       ///< drilling axis where the code says so
  bool rigid = false;  ///< always in step with the spindle
};

using enum HoleIn;
using enum HoleBottom;

constexpr HoleKind kDrill{};
constexpr HoleKind kDwell{once, dwell};
constexpr HoleKind kPeckBack{pecks_back};
constexpr HoleKind kPeckOut{pecks_out};
constexpr HoleKind kFeedOut{once, nothing, HoleOut::feed};
constexpr HoleKind kDwellFeedOut{once, dwell, HoleOut::feed};
constexpr HoleKind kStop{once, spindle_stop};
constexpr HoleKind kFine{once, orient_shift};
constexpr HoleKind kBack{up, orient_shift};
constexpr HoleKind kManual{once, operator_out};
constexpr HoleKind kTapRight{once, nothing, HoleOut::feed, HoleTap::right};
constexpr HoleKind kTapLeft{once, nothing, HoleOut::feed, HoleTap::left};

constexpr HoleCode kMill[] = {{730, "G73", kPeckBack},
                              {740, "G74", kTapLeft},
                              {760, "G76", kFine},
                              {810, "G81", kDrill},
                              {820, "G82", kDwell},
                              {830, "G83", kPeckOut},
                              {840, "G84", kTapRight},
                              {842, "G84.2", kTapRight, 0, true},
                              {843, "G84.3", kTapLeft, 0, true},
                              {850, "G85", kFeedOut},
                              {860, "G86", kStop},
                              {870, "G87", kBack},
                              {880, "G88", kManual},
                              {890, "G89", kDwellFeedOut}};

// 0i-T: face (Z) and side (X). Q makes G83/G87 peck; which way, a parameter says.
constexpr HoleCode kTurning[] = {{810, "G81", kDrill, 'Z'},
                                 {820, "G82", kDwell, 'Z'},
                                 {830, "G83", {pecks_out, dwell}, 'Z'},
                                 {831, "G83.1", {pecks_back, dwell}, 'Z'},
                                 {840, "G84", kTapRight, 'Z'},
                                 {842, "G84.2", kTapRight, 'Z', true},
                                 {850, "G85", kDwellFeedOut, 'Z'},
                                 {870, "G87", {pecks_out, dwell}, 'X'},
                                 {880, "G88", kTapRight, 'X'},
                                 {890, "G89", kDwellFeedOut, 'X'}};

constexpr HoleCode kK2000[] = {
    {810, "G81", kDrill},    {820, "G82", kDwell},     {830, "G83", kPeckOut}, {835, "G83.5", kPeckBack},
    {840, "G84", kTapRight}, {845, "G84.5", kTapLeft}, {850, "G85", kFeedOut}, {860, "G86", kStop},
    {865, "G86.5", kFine},   {870, "G87", kBack},      {880, "G88", kManual},  {890, "G89", kDwellFeedOut}};

constexpr HoleCode k200t[] = {{730, "G73", kPeckBack, 'Z'}, {810, "G81", kDrill, 'Z'},
                              {820, "G82", kDwell, 'Z'},    {830, "G83", {pecks_out_feed}, 'Z'},
                              {850, "G85", kFeedOut, 'Z'},  {860, "G86", kStop, 'Z'}};

std::span<const HoleCode> codes_of(HoleFamily family) {
  switch (family) {
    case HoleFamily::mill:
      return kMill;
    case HoleFamily::turning:
      return kTurning;
    case HoleFamily::k2000:
      return kK2000;
    case HoleFamily::lathe_200t:
      return k200t;
    case HoleFamily::none:
      break;
  }
  return {};
}

struct Target {
  std::uint32_t axes = 0;         ///< that move to the hole
  interp::AxisVector step{};      ///< nano units; added for every repetition when incremental
  std::uint32_t incremental = 0;  ///< axes whose step is an increment
};

class HoleRun final : public interp::MoveSource {
 public:
  HoleRun(const Executor& ex, const Hole& hole, std::size_t axis, std::array<std::size_t, 2> plane,
          Target target, std::int64_t times, std::int32_t clamp_m)
      : hole_(hole),
        axis_(axis),
        plane_(plane),
        target_(target),
        left_(times),
        clamp_m_(clamp_m),
        feed_(ex.feed_mm),
        unit_(ex.feed_unit) {}

  bool next(Executor& ex) override {
    for (;;) {
      switch (stage_) {
        case Stage::position: {
          if (left_-- <= 0) return false;
          stage_ = Stage::clamp;
          if (go_to_hole(ex)) return true;
          break;
        }
        case Stage::clamp:
          stage_ = Stage::drill;
          center_ = {ex.slide_mm(plane_[0]), ex.slide_mm(plane_[1])};
          moves_ = drill(hole_);
          if (clamp_m_ != 0) {
            m_code(ex, clamp_m_);
            return true;
          }
          break;
        case Stage::drill: {
          HoleMove move;
          if (!moves_.next(move)) {
            stage_ = Stage::position;
            if (clamp_m_ != 0) {
              m_code(ex, clamp_m_ + 1);
              return true;
            }
            break;
          }
          if (emit(ex, move)) return true;
          break;
        }
      }
    }
  }

 private:
  enum class Stage : std::uint8_t { position, clamp, drill };

  bool go_to_hole(Executor& ex) {
    if (target_.axes == 0) return false;
    for (std::uint32_t mask = target_.axes; mask != 0; mask &= mask - 1) {
      const auto i = static_cast<std::size_t>(std::countr_zero(mask));
      const auto step = static_cast<std::int64_t>(target_.step[i]);
      interp::ProgramAxis& axis = ex.axes[i];
      axis.position = (target_.incremental >> i & 1u) != 0 ? axis.position + step : step;
    }
    rapid(ex, target_.axes);
    return true;
  }
  void rapid(Executor& ex, std::uint32_t axes) {
    auto& motion = ex.emit<interp::Rapid>();
    ex.fill_motion(motion, axes);
    motion.linear = ex.linear_rapid;
  }
  void m_code(Executor& ex, std::int32_t number) {
    auto& sent = ex.emit<interp::MCode>();
    sent.at = ex.at;
    sent.modal = ex.modal;
    sent.code = number;
  }
  static void set(Executor& ex, std::size_t axis, double slide) {
    ex.axes[axis].position = std::llround(slide / ex.axes[axis].mm_per_unit * 1e9);
  }

  bool emit(Executor& ex, const HoleMove& move) {
    using Kind = HoleMove::Kind;
    const std::uint32_t mask = 1u << axis_;
    switch (move.kind) {
      case Kind::rapid:
      case Kind::feed: {
        const double before = ex.work_now[axis_];
        set(ex, axis_, move.to);
        if (ex.shown(axis_) == before) return false;
        if (move.kind == Kind::rapid) {
          rapid(ex, mask);
        } else {
          auto& motion = ex.emit<interp::Feed>();
          ex.fill_motion(motion, mask);
          motion.feed = feed_;
          motion.unit = unit_;
        }
        return true;
      }
      case Kind::dwell: {
        auto& pause = ex.emit<interp::Dwell>();
        pause.at = ex.at;
        pause.modal = ex.modal;
        pause.seconds = move.seconds;
        return true;
      }
      case Kind::spindle:
        ex.spindle_direction = move.direction;
        ex.emit_spindle();
        return true;
      case Kind::orient:
        m_code(ex, 19);
        return true;
      case Kind::shift: {
        std::uint32_t moved = 0;
        const std::array<double, 2> by{move.u, move.v};
        for (std::size_t i = 0; i < 2; ++i) {
          const std::size_t axis = plane_[i];
          if (axis == axis_) continue;
          const double before = ex.work_now[axis];
          set(ex, axis, center_[i] + by[i]);
          if (ex.shown(axis) != before) moved |= 1u << axis;
        }
        if (moved == 0) return false;
        rapid(ex, moved);
        return true;
      }
      case Kind::operator_stop: {
        auto& stop = ex.emit<interp::Stop>();
        stop.at = ex.at;
        stop.modal = ex.modal;
        return true;
      }
      case Kind::tap: {
        set(ex, axis_, move.to);
        auto& motion = ex.emit<interp::Tap>();
        ex.fill_motion(motion, mask);
        motion.bottom_work = motion.end_work;
        motion.bottom_machine = motion.end_machine;
        motion.bottom_work[axis_] = move.bottom / ex.axes[axis_].mm_per_unit;
        motion.bottom_machine[axis_] = move.bottom + ex.modal.work_zero[axis_];
        motion.kind = hole_.follows ? interp::TapKind::follows : interp::TapKind::rigid;
        motion.pitch_mm = hole_.pitch_mm;
        motion.rpm = ex.rpm;
        motion.direction = move.direction;
        motion.dwell_s = move.seconds;
        return true;
      }
    }
    return false;
  }

  Hole hole_;
  std::size_t axis_;
  std::array<std::size_t, 2> plane_;
  Target target_;
  std::int64_t left_;
  std::int32_t clamp_m_;
  double feed_;
  interp::FeedUnit unit_;
  Stage stage_ = Stage::position;
  std::array<double, 2> center_{};
  HoleMoves moves_;
};

char drilling_axis(Executor& ex, const Rules& rules, const HoleCode& code) {
  if (code.axis != 0) return code.axis;
  if (rules.holes == HoleFamily::k2000) {
    if (!ex.block.has('J')) return ex.cycle.hole.entered ? ex.axes[ex.cycle.hole.axis].name : 'Z';
    const double j = ex.block['J'].value();
    return j == 1 ? 'X' : j == 2 ? 'Y' : 'Z';
  }
  if (!ex.data.bit("5101#0")) return 'Z';  // FXY
  constexpr char kNormal[] = {'Z', 'Y', 'X'};
  return kNormal[static_cast<std::size_t>(ex.plane)];
}

// Level words: bottom and R of this block, kept for the next positions.
bool take_levels(Executor& ex, const Rules& rules, char name) {
  interp::HoleWords& words = ex.cycle.hole;
  const program::Block& b = ex.block;
  const std::size_t axis = words.axis;
  const char step = rules.holes == HoleFamily::mill ? 0 : name == 'X' ? 'U' : name == 'Y' ? 'V' : 'W';
  const bool by_letter =
      step != 0 && b.has(step) && (ex.incremental_letters & program::letter_bit(step)) != 0;
  if (b.has('R')) {
    const bool from_initial = rules.r_from_initial || ex.incremental;
    const double r = rules.r_as_axis ? slide_word(ex, b['R'], axis) : ex.length_mm(b['R']);
    words.reference = from_initial ? words.initial + r : r;
    words.has_reference = true;
  }
  if (!words.has_reference) words.reference = words.initial;
  if (by_letter || b.has(name)) {
    const double value = slide_word(ex, by_letter ? b[step] : b[name], axis);
    const bool from_r = by_letter || ex.incremental;
    const double base = rules.holes == HoleFamily::lathe_200t ? words.initial : words.reference;
    words.bottom = from_r ? base + value : value;
    words.has_bottom = true;
  }
  return true;
}

bool take_counts(Executor& ex, const Rules& rules) {
  interp::HoleWords& words = ex.cycle.hole;
  const program::Block& b = ex.block;
  if (b.has('Q'))
    words.peck = std::fabs(count_length(ex, b['Q'], rules.holes == HoleFamily::turning ? 0.001 : 0));
  if (b.has('P')) words.dwell_s = b['P'].value() / 1000;
  if (words.dwell_s < 0) return fail(ex, rules, Fault::value, 'P');
  if (rules.holes == HoleFamily::lathe_200t && b.has('K')) words.retract = std::fabs(ex.length_mm(b['K']));
  return true;
}

// How often this block drills. @return -1 after an alarm; 0: only the words are kept.
std::int64_t repeats(Executor& ex, const Rules& rules) {
  const program::Block& b = ex.block;
  if (rules.holes == HoleFamily::lathe_200t) return 1;
  const char letter = rules.holes == HoleFamily::k2000 ? 'L' : 'K';
  if (rules.holes == HoleFamily::k2000 && b.has('K')) {
    if (b['K'].value() != 0) return fail(ex, rules, Fault::hole_k, 'K'), -1;
    if (ex.data.bit("P3300.7")) return 0;
  }
  const char used = b.has(letter) ? letter : rules.holes == HoleFamily::mill && b.has('L') ? 'L' : 0;
  if (used == 0) return 1;
  const double value = b[used].value();
  if (value < 0 || value > 9'999 || value != std::floor(value))
    return fail(ex, rules, Fault::hole_k, used), -1;
  if (value == 0 && rules.holes != HoleFamily::k2000 && ex.data.bit("5105#4")) return 1;  // K0D
  return static_cast<std::int64_t>(value);
}

bool returns_to_r(const Executor& ex) {
  const dialects::GCode* row = ex.table->find(990);  // where G99 is a return level at all
  return row != nullptr && row->handler == nullptr && row->group != 0 && ex.modal.g[row->group] == 990;
}

// The way out of the hole's wall for G76, G86.5, G87.
void shift_of(const Executor& ex, const Rules& rules, double amount, Hole& hole) {
  if (rules.holes == HoleFamily::k2000) {
    const int which = (ex.data.bit("P3300.4") ? 1 : 0) + (ex.data.bit("P3300.5") ? 2 : 0);
    (which >= 2 ? hole.shift_v : hole.shift_u) = which % 2 != 0 ? -amount : amount;
    return;
  }
  const double direction = ex.data.parameter("5148/Z", ex.data.parameter("5148", 1));
  (std::fabs(direction) == 2 ? hole.shift_v : hole.shift_u) = direction < 0 ? -amount : amount;
}

bool prepare_tap(Executor& ex, const Rules& rules, const HoleCode& code, Hole& hole) {
  interp::HoleWords& words = ex.cycle.hole;
  const bool k2000 = rules.holes == HoleFamily::k2000;
  if (ex.cycle.rigid_next) words.rigid = true;
  ex.cycle.rigid_next = false;
  hole.synchronous =
      code.rigid || words.rigid ||
      (k2000 ? ex.data.parameter("P2730") != 0 || ex.data.bit("P2700.3") : ex.data.bit("5200#0"));
  hole.stop_before_reversal = k2000 || !ex.data.bit("5105#3");
  if (!hole.synchronous) return true;
  const program::Block& b = ex.block;
  if (!(ex.rpm > 0) || ex.constant_surface_speed) return fail(ex, rules, Fault::rigid_speed, 'S');
  const double most = ex.data.parameter("5241");
  if (!k2000 && most > 0 && ex.rpm > most) return fail(ex, rules, Fault::rigid_speed, 'S');
  if (k2000) {  // F is the lead, or I threads per inch
    if (b.has('F')) words.lead_mm = b['F'].value() * ex.unit_mm;
    if (b.has('I') && b['I'].value() > 0) words.lead_mm = 25.4 / b['I'].value();
    hole.pitch_mm = words.lead_mm;
    if (std::fabs(hole.bottom - hole.reference) > 1491 * hole.pitch_mm && hole.pitch_mm > 0)
      return fail(ex, rules, Fault::rigid_distance, 'Z');
    hole.tap_pecks_out = !ex.data.bit("P2700.7");
    hole.clearance = ex.data.parameter("P3410");
  } else {
    hole.pitch_mm = ex.feed_unit == interp::FeedUnit::mm_per_revolution ? ex.feed_mm : ex.feed_mm / ex.rpm;
    hole.tap_pecks_out = ex.data.bit("5200#5");  // PCP
    hole.clearance = ex.data.parameter("5213");
  }
  if (!(hole.pitch_mm > 0)) return fail(ex, rules, Fault::rigid_feed, 'F');
  return true;
}

}  // namespace

bool hole_cycle(Executor& ex) {
  const Rules& rules = rules_of(ex.dialect);
  const program::Block& b = ex.block;
  const bool modal = ex.code->phase == dialects::Phase::hole;
  interp::HoleWords& words = ex.cycle.hole;
  const auto codes = codes_of(rules.holes);
  const auto code = std::find_if(codes.begin(), codes.end(),
                                 [&](const HoleCode& one) { return one.tenths == ex.code->tenths; });
  if (code == codes.end())
    return ex.alarm(dialects::AlarmReason::g_unavailable, ex.code_column, std::string(ex.code->name));

  const char name = drilling_axis(ex, rules, *code);
  const auto axis = ex.axis_named(name);
  if (!axis) return fail(ex, rules, Fault::hole_axis, name);
  if (modal && words.entered && words.axis != *axis) {  // another drilling axis: its words begin anew
    const dialects::GCode* kept = words.code;
    words = {};
    words.code = kept;
  }
  if (!words.entered || !modal) {
    words.axis = *axis;
    words.initial = ex.slide_mm(*axis);
    words.entered = true;
  }
  if ((b.words & (ex.axis_letters | program::letter_bit('R'))) == 0) return true;  // nothing to drill

  if (!take_levels(ex, rules, name) || !take_counts(ex, rules)) return false;
  Target target;
  for (std::uint32_t mask = b.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    const auto i = static_cast<std::size_t>(ex.axis_of[letter]);
    if (i == *axis) continue;
    const bool by = ex.incremental || (ex.incremental_letters >> letter & 1u) != 0;
    target.axes |= 1u << i;
    if (by) target.incremental |= 1u << i;
    target.step[i] =
        static_cast<double>(ex.round_to(ex.nano(b.word[letter], ex.axes[i].increment), ex.axes[i].increment));
  }
  for (const char letter : {'I', 'J'}) {  // small-hole pecking, shifts by I and J
    if (rules.holes == HoleFamily::mill && b.has(letter))
      return fail(ex, rules, Fault::unfinished, letter, std::string(code->name) + ' ' + letter);
  }
  const std::int64_t times = repeats(ex, rules);
  if (times < 0) return false;
  if (times == 0) {  // the words are kept; K2000 goes to the position
    if (rules.holes != HoleFamily::k2000 || target.axes == 0) return true;
    std::uint32_t moved = 0;
    const auto words_kept = ex.block.words;
    ex.block.words &= ~(program::letter_bit(name));
    const bool ok = ex.take_targets(moved);
    ex.block.words = words_kept;
    if (!ok) return false;
    auto& motion = ex.emit<interp::Rapid>();
    ex.fill_motion(motion, moved);
    return true;
  }
  if (!words.has_bottom) return fail(ex, rules, Fault::hole_depth, name);

  Hole hole;
  hole.kind = code->kind;
  hole.initial = words.initial;
  hole.reference = words.reference;
  hole.bottom = words.bottom;
  hole.to_reference = returns_to_r(ex) && hole.kind.in != HoleIn::up;
  hole.peck = words.peck;
  hole.dwell_s = words.dwell_s;
  hole.turning = ex.spindle_direction == SpindleDirection::stop ? SpindleDirection::cw : ex.spindle_direction;
  const bool pecking = hole.kind.in == HoleIn::pecks_back || hole.kind.in == HoleIn::pecks_out ||
                       hole.kind.in == HoleIn::pecks_out_feed;
  if (pecking && hole.peck <= 0 && rules.holes != HoleFamily::turning)
    return fail(ex, rules, Fault::hole_peck, 'Q');
  if (rules.holes == HoleFamily::turning && code->tenths != 831 && pecking && !ex.data.bit("5101#2")) {
    hole.kind.in = HoleIn::pecks_back;  // RTR = 0: high-speed pecking
  }
  const bool back = hole.kind.in == HoleIn::pecks_back;
  hole.clearance =
      rules.holes == HoleFamily::lathe_200t
          ? words.retract
          : ex.data.parameter(back ? rules.parameters.peck_back : rules.parameters.peck_clearance);
  if (hole.kind.bottom == HoleBottom::orient_shift) {
    if (hole.kind.in != HoleIn::up && rules.holes == HoleFamily::k2000 && words.peck <= 0)
      return fail(ex, rules, Fault::hole_peck, 'Q');
    shift_of(ex, rules, words.peck, hole);
  }
  // R lies between the initial level and the bottom; back boring turns the last two round.
  const double depth = hole.bottom - hole.reference;
  if (std::fabs(depth) < kTiny) return fail(ex, rules, Fault::hole_depth, name);
  const double approach = hole.reference - hole.initial;
  const bool same_way = std::fabs(approach) < kTiny || (approach < 0) == (depth < 0);
  if (hole.kind.in == HoleIn::up ? same_way : false) return fail(ex, rules, Fault::hole_depth, name);
  if (hole.kind.tap != HoleTap::none && !prepare_tap(ex, rules, *code, hole)) return false;
  if (!(hole.synchronous && rules.holes == HoleFamily::k2000) && !check_feed(ex)) return false;
  ex.cycle.name = code->name;
  ex.cycle.starts_cycle = true;
  std::array<std::size_t, 2> plane{0, 0};
  std::size_t count = 0;
  for (std::size_t i = 0; i < ex.axes.size() && count < 2; ++i) {
    if (i != *axis && !ex.axes[i].rotary) plane[count++] = i;
  }
  if (count == 1) plane[1] = *axis;
  if (count == 0) plane = {*axis, *axis};
  const std::int32_t clamp = words.clamp ? ex.cycle.clamp_m : 0;
  ex.cycle.running = std::make_unique<HoleRun>(ex, hole, *axis, plane, target, times, clamp);
  return true;
}

// G80.
bool hole_cancel(Executor& ex) {
  ex.cycle.hole = {};
  ex.cycle.rigid_next = false;
  return true;
}

// Tapping with the feed axis tied to the spindle: GSK G84/G88 and G33, K2000TC and 200T G93.
bool tapping(Executor& ex) {
  const Rules& rules = rules_of(ex.dialect);
  const program::Block& b = ex.block;
  const char name = ex.code->tenths == 880 ? 'X' : 'Z';
  const char step = name == 'X' ? 'U' : 'W';
  const auto axis = ex.axis_named(name);
  if (!axis) return fail(ex, rules, Fault::hole_axis, name);
  for (std::uint32_t mask = b.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    if (static_cast<std::size_t>(ex.axis_of[letter]) != *axis) {
      return fail(ex, rules, Fault::hole_axis, static_cast<char>('A' + letter));
    }
  }
  const auto bottom = target_word(ex, *axis, name, step);
  if (!bottom || std::fabs(*bottom - ex.slide_mm(*axis)) < kTiny) return true;  // no move: no tapping
  if (b.has('F') && b.has('I')) return ex.alarm(dialects::AlarmReason::thread_f_and_i, b['I'].column, "I");
  if (b.has('F')) ex.lead_mm = b['F'].value() * ex.unit_mm;
  if (b.has('I')) ex.lead_mm = b['I'].value() > 0 ? 25.4 / b['I'].value() : 0;
  if (!(ex.lead_mm > 0)) return fail(ex, rules, Fault::thread_lead, 'F');
  for (const char letter : {'L', 'Q', 'P'}) {
    if (b.has(letter) && b[letter].value() != 0 && !(letter == 'L' && b['L'].value() == 1))
      return fail(ex, rules, Fault::unfinished, letter, std::string("tapping ") + letter);
  }
  Hole hole;
  hole.kind = kTapRight;
  hole.initial = hole.reference = ex.slide_mm(*axis);
  hole.bottom = *bottom;
  hole.pitch_mm = ex.lead_mm;
  hole.synchronous = true;
  const bool rigid = ex.cycle.rigid_next || ex.data.bit(rules.rigid_tap_parameter);
  hole.follows = !rigid;
  if (rigid && !(ex.rpm > 0)) return fail(ex, rules, Fault::rigid_speed, 'S');
  if (!rigid && ex.spindle_direction == SpindleDirection::stop)
    return fail(ex, rules, Fault::rigid_program, 'S', "spindle not turning");
  if (ex.spindle_direction == SpindleDirection::ccw) hole.kind = kTapLeft;
  hole.pecks_from_retract = true;
  if (b.has('D')) hole.peck = std::fabs(ex.length_mm(b['D']));
  if (b.has('R')) hole.clearance = std::fabs(ex.length_mm(b['R']));
  if (hole.clearance == 0 || hole.peck >= std::fabs(hole.bottom - hole.reference))
    hole.peck = 0;  // in one go
  if (hole.peck > 0 && hole.clearance >= hole.peck) return fail(ex, rules, Fault::value, 'D');
  ex.cycle.name = ex.code->tenths == 330   ? "G33"
                  : ex.code->tenths == 930 ? "G93"
                  : name == 'X'            ? "G88"
                                           : "G84";
  ex.cycle.starts_cycle = true;
  ex.cycle.running =
      std::make_unique<HoleRun>(ex, hole, *axis, std::array<std::size_t, 2>{*axis, *axis}, Target{}, 1, 0);
  return true;
}

}  // namespace headstock::cycles
