// G36 and G37: the tool runs against a sensor whose place is known, and the offset in force is corrected by
// the difference (0i-D K.2, No.6241-6256; K2000TC L7558).
//
//   rapid to γ before the place → measuring feed, until the signal, at most to ε behind it
//   a signal outside ±ε, or none: alarm
#include <bit>
#include <cmath>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"
#include "interpreter/skip.hpp"

namespace headstock::interp::handlers {
namespace {

struct Measurement {
  std::size_t axis = 0;
  double target = 0;  ///< slide mm from the work zero
  double gamma = 0, epsilon = 0, feed = 0;
  std::int64_t number = 0;
  std::uint32_t column = 0;
};

class MeasureRun final : public MoveSource {
 public:
  explicit MeasureRun(const Measurement& wanted) : m_(wanted) {}

  bool next(Executor& ex) override {
    switch (stage_++) {
      case 0: {
        const double way = m_.target - ex.slide_mm(m_.axis);
        direction_ = way < 0 ? -1 : 1;
        if (std::fabs(way) > m_.gamma) {
          go(ex, m_.target - direction_ * m_.gamma);
          auto& rapid = ex.emit<Rapid>();
          ex.fill_motion(rapid, 1u << m_.axis);
          rapid.linear = true;
          rapid.exact_stop = true;
          return true;
        }
        ++stage_;
        [[fallthrough]];
      }
      case 1: {
        go(ex, m_.target + direction_ * m_.epsilon);
        auto& probe = ex.emit<Feed>();
        ex.fill_motion(probe, 1u << m_.axis);
        probe.feed = m_.feed;
        probe.exact_stop = true;
        probe.skip_signals = 1;  // the SKIP input
        ex.skip.machine = ex.machine_now;
        ex.skip.triggered = false;
        stage_ = 2;
        return true;
      }
      case 2:
        return evaluate(ex);
      default:
        return false;
    }
  }

 private:
  static void go(Executor& ex, std::size_t axis, double slide) {
    ex.axes[axis].position = std::llround(slide / ex.axes[axis].mm_per_unit * 1e9);
  }
  void go(Executor& ex, double slide) const { go(ex, m_.axis, slide); }

  // @return true after an alarm, which is an operation; false: the measurement is over.
  bool evaluate(Executor& ex) const {
    const double difference = ex.slide_mm(m_.axis) - m_.target;
    if (!ex.skip.triggered || std::fabs(difference) > m_.epsilon + 1e-9) {
      ex.alarm(AlarmReason::measure_signal, m_.column, std::string(1, ex.axes[m_.axis].name));
      return true;
    }
    const auto& rules = ex.dialect.measure;
    const double by = ex.data.bit(rules.subtract_parameter) ? -difference : difference;
    auto& tools = ex.data.tools;
    const auto row = static_cast<std::size_t>(m_.number);
    if (tools.size() <= row) tools.resize(row + 1);
    const bool lathe = ex.dialect.tools.lathe;
    const double page = lathe ? tool_offset::to_page(ex, m_.axis, by, !rules.into_geometry) : by;
    const std::size_t cell = lathe ? m_.axis : ex.axis_named('Z').value_or(m_.axis);
    const std::string place = "tool/" + std::to_string(m_.number);
    const std::string name = lathe ? std::string(1, ex.axes[m_.axis].name) : "length";
    const auto put = [&ex](double& value, double wanted, const std::string& what) {
      const double before = value;
      value = wanted;
      if (before != wanted) ex.report_change(what, before, wanted);
    };
    double& wear = tools[row].wear[cell];
    if (rules.into_geometry) {
      double& geometry = tools[row].geometry[cell];
      put(geometry, geometry + wear + page, place + "/geometry/" + name);
      put(wear, 0, place + "/wear/" + name);
    } else {
      put(wear, wear + page, place + (lathe ? "/wear/" + name : "/length_wear"));
    }
    // A lathe's offset is in force: the position page changes at once. A length counts from the next H on.
    if (lathe) tool_offset::grow(ex, m_.axis, ex.dialect.tools.sign * by);
    return false;
  }

  Measurement m_;
  int stage_ = 0;
  double direction_ = 1;
};

}  // namespace

bool measure(Executor& ex) {
  const auto& rules = ex.dialect.measure;
  const auto refuse = [&ex](AlarmReason reason, char letter) {
    return ex.alarm(reason, letter != 0 && ex.block.has(letter) ? ex.block[letter].column : ex.code_column,
                    letter != 0 ? std::string(1, letter) : std::string(ex.code->name));
  };
  const char offset_word = ex.dialect.tools.lathe ? 'T' : 'H';
  if (ex.block.has(offset_word)) return refuse(AlarmReason::measure_with_offset, offset_word);
  if (!ex.compensation_is_off()) return refuse(AlarmReason::skip_not_allowed, 0);
  const std::uint32_t words = ex.block.words & ex.axis_letters;
  if (std::popcount(words) != 1 || ex.incremental || (words & ex.incremental_letters) != 0)
    return refuse(AlarmReason::measure_axis, 0);
  const auto letter = static_cast<unsigned>(std::countr_zero(words));
  Measurement m;
  m.axis = static_cast<std::size_t>(ex.axis_of[letter]);
  const char wanted = rules.axis[ex.code->tenths == 360 ? 0 : 1];
  if ((wanted != 0 && ex.axes[m.axis].name != wanted) || ex.axes[m.axis].rotary)
    return refuse(AlarmReason::measure_axis, static_cast<char>('A' + letter));
  m.number = ex.dialect.tools.lathe ? ex.modal.offset : ex.length_offset;
  if (!tool_offset::counts_on(ex, m.axis))
    return refuse(AlarmReason::measure_no_length, static_cast<char>('A' + letter));
  if (m.number <= 0) return refuse(AlarmReason::measure_number, 0);
  const std::size_t set = ex.axes[m.axis].name == 'Y' ? 1 : ex.axes[m.axis].name == 'Z' ? 2 : 0;
  const auto value = [&ex, set](const std::array<std::string_view, 3>& of) {
    const double own = of[set].empty() ? 0 : ex.data.parameter(of[set]);
    return own != 0 ? own : ex.data.parameter(of[0]);
  };
  m.feed = value(rules.feed);
  m.gamma = value(rules.gamma);
  m.epsilon = value(rules.epsilon);
  if (m.feed <= 0) return ex.alarm(AlarmReason::feed_missing, ex.code_column, std::string(rules.feed[0]));
  // Without a distance at all the tool would meet the sensor at rapid.
  if (!(m.gamma > m.epsilon && m.epsilon > 0))
    return ex.alarm(AlarmReason::value_range, ex.code_column, std::string(rules.gamma[0]));
  const ProgramAxis& axis = ex.axes[m.axis];
  const std::int64_t place = ex.round_to(ex.axis_value(ex.block.word[letter], axis), axis.increment);
  m.target = static_cast<double>(place) / 1e9 * axis.mm_per_unit;
  m.column = ex.code_column;
  ex.cycle.name = ex.code->tenths == 360 ? "G36" : "G37";
  ex.cycle.starts_cycle = true;
  ex.cycle.running = std::make_unique<MeasureRun>(m);
  return true;
}

}  // namespace headstock::interp::handlers
