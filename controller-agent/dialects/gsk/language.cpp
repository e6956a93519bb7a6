#include "dialects/gsk/language.hpp"

#include <utility>

#include "interpreter/executor.hpp"

namespace headstock::dialects::gsk {
namespace {

using interp::Executor;
using R = AlarmReason;

constexpr std::int64_t kMostGear = 4;
constexpr std::int64_t kMostUserCode = 99;  // M, S and T of two digits may be sub-programs (218T L846)
constexpr std::uint32_t kProgramsOfM = 9'000, kProgramsOfS = 9'100, kProgramsOfT = 9'200;

class Language final : public interp::OwnLanguage {
 public:
  explicit Language(const SpindleRules& rules) : rules_(rules) {}

  // Rotary axes of type A (2000TC L12400-L12420): absolute positions count within a turn.
  void start(Executor& ex) override {
    if (rules_.type_b.empty()) return;
    const bool rolls =
        ex.data.parameter(rules_.type_b, 1) == 0 && ex.data.parameter(rules_.rolls_over, 1) != 0;
    ex.any_rolls_over = false;
    for (auto& axis : ex.axes) {
      axis.rolls_over = axis.rotary && rolls;
      axis.by_sign = ex.data.bit(rules_.by_sign);
      axis.turn = 360 * program::kNano;
      ex.any_rolls_over = ex.any_rolls_over || axis.rolls_over;
    }
  }

  // S on a spindle with gears: S1…S4 is the output of that gear, S0 none (218T L461, 2000TC L1335).
  Taken take_spindle(Executor& ex) override {
    if (ex.data.parameter(rules_.analog, 1) != 0) return Taken::plain;
    const program::Word& word = ex.block['S'];
    if (ex.constant_surface_speed) {
      ex.alarm(R::surface_speed_gear, word.column, "G96");
      return Taken::done;
    }
    const std::int64_t gear = ex.whole('S', R::spindle_gear);
    if (gear < 0) return Taken::done;
    if (gear > 9 && gear <= kMostUserCode && ex.data.bit(rules_.subprograms)) {
      (void)call_after(ex, kProgramsOfS + static_cast<std::uint32_t>(gear), word);
      return Taken::done;
    }
    if (gear > kMostGear || word.digit_count > 2) {
      ex.alarm(R::spindle_gear, word.column, "S" + std::to_string(gear));
      return Taken::done;
    }
    ex.modal.spindle_speed = static_cast<double>(gear);
    auto& state = ex.emit<interp::Spindle>();
    state.at = ex.at;
    state.direction = ex.spindle_direction;
    state.speed = ex.rpm;
    state.gear = static_cast<std::uint8_t>(gear);
    return Taken::done;
  }

  // T of two digits is no station: O92tt (218T L870). A station above their number is an alarm (L899).
  Taken take_block(Executor& ex) override {
    if (rules_.stations.empty() || !ex.block.has('T')) return Taken::plain;
    const program::Word& word = ex.block['T'];
    if (word.digits > 0 && word.digits <= kMostUserCode && word.decimals == 0 &&
        ex.data.bit(rules_.subprograms)) {
      ex.block.words &= ~program::letter_bit('T');
      return call_after(ex, kProgramsOfT + static_cast<std::uint32_t>(word.digits), word) ? Taken::plain
                                                                                          : Taken::done;
    }
    const double stations = ex.data.parameter(rules_.stations);
    if (stations <= 0 || word.value() < (stations + 1) * 100) return Taken::plain;
    ex.alarm(R::t_not_allowed, word.column, "T" + std::to_string(word.integer()));
    return Taken::done;
  }

  bool m_code(Executor& ex, const program::Code& code) override {
    const std::int32_t number = code.tenths / 10;
    if (number >= 41 && number <= 44) return change_gear(ex, code);
    if (rules_.subprograms.empty()) return call(ex, static_cast<std::uint32_t>(number), code.column);
    if (number > kMostUserCode || !ex.data.bit(rules_.subprograms)) return ex.alarm(R::illegal_m, code, 'M');
    if (in_mdi(ex, code.column, "M")) return false;
    return call(ex, kProgramsOfM + static_cast<std::uint32_t>(number), code.column);
  }

 private:
  // Codes that are sub-programs are an alarm in MDI (218T L864).
  bool in_mdi(Executor& ex, std::uint32_t column, const char* letter) const {
    if (ex.switches.origin != interp::ProgramOrigin::mdi) return false;
    ex.alarm(R::value_range, column, letter);
    return true;
  }

  // Once the block is done. @return false after an alarm.
  bool call_after(Executor& ex, std::uint32_t number, const program::Word& word) const {
    if (in_mdi(ex, word.column, number >= kProgramsOfT ? "T" : "S")) return false;
    ex.word_call = {0, number, false, false};
    ex.sub_call = &ex.word_call;
    ex.sub_call_column = word.column;
    return true;
  }

  bool call(Executor& ex, std::uint32_t number, std::uint32_t column) const {
    return ex.call(ex.programs == nullptr ? nullptr : ex.programs->open_number(number), number, 1, column);
  }

  // M41-M44: only an analog spindle whose gears change by themselves (218T L4453).
  bool change_gear(Executor& ex, const program::Code& code) const {
    if (!ex.data.bit(rules_.gear_change) || ex.data.parameter(rules_.analog, 1) == 0)
      return ex.alarm(R::gear_change, code, 'M');
    auto& sent = ex.emit<interp::MCode>();
    sent.at = ex.at;
    sent.modal = ex.modal;
    sent.code = code.tenths / 10;
    sent.after_motion = true;
    return true;
  }

  SpindleRules rules_;
};

}  // namespace

std::unique_ptr<interp::OwnLanguage> make_language(const SpindleRules& rules) {
  return std::make_unique<Language>(rules);
}

// P116/P117: the positive ends of X and Z, P118/P119 the negative ones; S177.0 forbids the outside.
bool stroke_zone_on(Executor& ex) {
  struct Corner {
    char axis;
    std::string_view most, least;
  };
  auto& check = ex.emit<interp::StrokeCheck>();
  check.at = ex.at;
  check.on = true;
  check.outside_forbidden = ex.data.bit("S177.0");
  for (const Corner& corner : {Corner{'X', "P116", "P118"}, Corner{'Z', "P117", "P119"}}) {
    const auto axis = ex.axis_named(corner.axis);
    const auto& set = ex.data.parameters;
    if (!axis || (!set.contains(corner.most) && !set.contains(corner.least))) continue;
    check.most[*axis] = ex.page_to_slide(*axis, ex.data.parameter(corner.most));
    check.least[*axis] = ex.page_to_slide(*axis, ex.data.parameter(corner.least));
    if (check.most[*axis] < check.least[*axis]) std::swap(check.most[*axis], check.least[*axis]);
    check.axes |= 1u << *axis;
  }
  return true;
}

bool stroke_zone_off(Executor& ex) {
  ex.emit<interp::StrokeCheck>().at = ex.at;
  return true;
}

}  // namespace headstock::dialects::gsk
