#include "operation/acceleration.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

namespace headstock::operation {
namespace {

constexpr double kMeanUnit = 1000.0 / 60;  // (m/min)/s in mm/s² (K2000TC L4866)
constexpr double kNoShare = 1e-9;

enum class Unit : std::uint8_t {
  acceleration,     ///< mm/s² of an axis
  time_to_rapid,    ///< ms from standing to the axis' rapid rate
  time_to_feed,     ///< ms from standing to the feed of the move
  time_to_highest,  ///< ms from standing to the axis' highest cutting feed
  mean              ///< (m/min)/s along the path
};
enum class Way : std::uint8_t { both, up, down };

/// A bit that has to stand so for a row to count; an empty one always counts.
struct When {
  std::string_view bit;
  bool on = true;
  bool unset = false;  ///< what it is when nobody has set it
};

struct Row {
  std::string_view profile;  // beginning of its name
  MotionKind kind;
  Way way;
  std::string_view parameter;  // ends in '/': one for each axis
  char axis;                   // otherwise the axis it is for; 0: all
  Unit unit;
  When first = {}, second = {};
};

using enum MotionKind;
using enum Unit;
constexpr When kS{"S168.0", true, true}, kLinear{"S168.0", false, true}, kBefore{"S168.1", false},
    kAfter{"S168.1", true};
constexpr When kCutS{"S168.2", true, true}, kCutLinear{"S168.2", false, true},
    kCutBefore{"S168.3", false, true}, kCutAfter{"S168.3", true, true};
constexpr When kThreadS{"S168.4", true}, kThreadLinear{"S168.4", false};
constexpr When k218S{"P009.4", true}, k218Linear{"P009.4", false};
constexpr When kFrp{"19501#5", true}, kNotFrp{"19501#5", false}, kLrp{"1401#1", true},
    kNotLrp{"P0004.1", false}, kK2Lrp{"P0004.1", true};

constexpr Row kRows[] = {
    // FANUC 0i-D L21277, L22088-L22162, L55676-L55887. Rapid before interpolation needs straight positioning.
    {"fanuc-0i", rapid, Way::both, "1620/", 0, time_to_rapid, kNotFrp},
    {"fanuc-0i", rapid, Way::both, "1671/", 0, acceleration, kFrp, kLrp},
    {"fanuc-0i", cutting, Way::both, "1622/", 0, time_to_feed},
    {"fanuc-0i", cutting_ahead, Way::both, "1660/", 0, acceleration},
    {"fanuc-0i", thread, Way::both, "1626/", 0, time_to_feed},
    // GSK 2000TC S168, P305-P326 (L12171-L12195, L13677-L13800)
    {"gsk-2000tc", rapid, Way::both, "P305", 'X', time_to_rapid, kLinear, kBefore},
    {"gsk-2000tc", rapid, Way::both, "P306", 'Z', time_to_rapid, kLinear, kBefore},
    {"gsk-2000tc", rapid, Way::both, "P307", 'X', time_to_rapid, kS, kBefore},
    {"gsk-2000tc", rapid, Way::both, "P308", 'Z', time_to_rapid, kS, kBefore},
    {"gsk-2000tc", rapid, Way::both, "P309", 'X', time_to_rapid, kLinear, kAfter},
    {"gsk-2000tc", rapid, Way::both, "P310", 'Z', time_to_rapid, kLinear, kAfter},
    {"gsk-2000tc", rapid, Way::both, "P311", 'X', time_to_rapid, kS, kAfter},
    {"gsk-2000tc", rapid, Way::both, "P312", 'Z', time_to_rapid, kS, kAfter},
    {"gsk-2000tc", cutting, Way::both, "P313", 0, time_to_highest, kCutLinear, kCutBefore},
    {"gsk-2000tc", cutting, Way::both, "P314", 0, time_to_highest, kCutS, kCutBefore},
    {"gsk-2000tc", cutting, Way::both, "P315", 0, time_to_feed, kCutLinear, kCutAfter},
    {"gsk-2000tc", cutting, Way::both, "P316", 0, time_to_feed, kCutS, kCutAfter},
    {"gsk-2000tc", thread, Way::both, "P321", 0, time_to_highest, kThreadLinear},
    {"gsk-2000tc", thread, Way::both, "P324", 0, time_to_highest, kThreadS},
    // GSK 218T P009.4-.7, P023-P031, P069 (L4654-L4680, L5078-L5148)
    {"gsk-218t", rapid, Way::both, "P023", 'X', time_to_rapid, k218Linear},
    {"gsk-218t", rapid, Way::both, "P024", 'Z', time_to_rapid, k218Linear},
    {"gsk-218t", rapid, Way::both, "P025", 'X', time_to_rapid, k218S},
    {"gsk-218t", rapid, Way::both, "P026", 'Z', time_to_rapid, k218S},
    {"gsk-218t", cutting, Way::both, "P031", 0, time_to_highest, k218Linear},
    {"gsk-218t", cutting, Way::up, "P029", 0, time_to_highest, k218S},
    {"gsk-218t", cutting, Way::down, "P030", 0, time_to_highest, k218S},
    {"gsk-218t", thread, Way::both, "P069", 0, time_to_highest},
    // K2000TC: before interpolation, over blocks (L4826-L4889, table L4905)
    {"k2000tc", rapid, Way::up, "P6432", 0, mean, kK2Lrp},
    {"k2000tc", rapid, Way::down, "P6433", 0, mean, kK2Lrp},
    {"k2000tc", rapid, Way::both, "P6440", 0, mean, kNotLrp},
    {"k2000tc", cutting, Way::up, "P6430", 0, mean},
    {"k2000tc", cutting, Way::down, "P6431", 0, mean},
    {"k2000tc", thread, Way::up, "P6480", 0, mean},
    {"k2000tc", thread, Way::down, "P6481", 0, mean},
    {"k2000tc", retreat, Way::both, "P6483", 0, mean},  // L3961, L12834
    // 200T/300T: time from standing to the highest cutting feed, for every motion (L8016-L8055)
    {"lathe-200t", rapid, Way::both, "AX2.1", 'X', time_to_highest},
    {"lathe-200t", rapid, Way::both, "AX2.2", 'Z', time_to_highest},
    {"lathe-200t", cutting, Way::both, "AX2.1", 'X', time_to_highest},
    {"lathe-200t", cutting, Way::both, "AX2.2", 'Z', time_to_highest},
    {"lathe-200t", thread, Way::both, "AX2.1", 'X', time_to_highest},
    {"lathe-200t", thread, Way::both, "AX2.2", 'Z', time_to_highest},
};

bool stands(const When& when, const interp::MachineData& data) {
  return when.bit.empty() || (data.parameter(when.bit, when.unset ? 1 : 0) != 0) == when.on;
}

/// The smaller of two limits, where 0 means none.
void lower(double& limit, double by) {
  if (by > 0 && (limit <= 0 || by < limit)) limit = by;
}

}  // namespace

/// Fills the rules from the rows of one controller.
struct AccelerationReader {
  const machine::Machine& machine;
  AccelerationRules& rules;

  void take(const Row& row, std::size_t axis, double value) const {
    if (!(value > 0)) return;
    AccelerationRules::Kind& kind = rules.kinds_[static_cast<std::size_t>(row.kind)];
    if (row.way != Way::down) set(kind.up, row.unit, axis, value);
    if (row.way != Way::up) set(kind.down, row.unit, axis, value);
  }

  void set(AccelerationRules::Limit& limit, Unit unit, std::size_t axis, double value) const {
    const machine::Axis& of = machine.axes[axis];
    switch (unit) {
      case acceleration:
        return lower(limit.axis[axis], value);
      case time_to_rapid:
        return lower(limit.axis[axis], of.rapid_mm_min / 60 / (value / 1000));
      case time_to_highest:
        return lower(limit.axis[axis], of.max_feed_mm_min / 60 / (value / 1000));
      case time_to_feed:
        limit.time_s[axis] = value / 1000;
        return;
      case mean:
        return lower(limit.along, value * kMeanUnit);
    }
  }
};

AccelerationRules AccelerationRules::read(const machine::Machine& machine, const interp::MachineData& data) {
  AccelerationRules rules;
  const AccelerationReader reader{machine, rules};
  for (const Row& row : kRows) {
    if (!machine.profile.starts_with(row.profile) || !stands(row.first, data) || !stands(row.second, data))
      continue;
    const bool per_axis = row.parameter.ends_with('/');
    for (std::size_t i = 0; i < machine.axes.size(); ++i) {
      const char name = machine.axes[i].name;
      if (row.axis != 0 && row.axis != name) continue;
      const std::string number = per_axis ? std::string(row.parameter) + name : std::string(row.parameter);
      reader.take(row, i, data.parameter(number));
    }
  }
  // Without an acceleration of its own a retreat is a positioning; a ratio then counts from the machine's.
  Kind& back = rules.kinds_[static_cast<std::size_t>(retreat)];
  if (!(back.up.along > 0)) {
    back = rules.kinds_[static_cast<std::size_t>(rapid)];
    for (std::size_t i = 0; i < machine.axes.size(); ++i) {
      for (Limit* limit : {&back.up, &back.down})
        lower(limit->axis[i], machine.axes[i].max_acceleration_mm_s2);
    }
  }
  return rules;
}

double AccelerationRules::allowed(const Limit& limit, const motion::Curve& curve, double feed_mm_s) {
  double most = limit.along, time_s = 0;
  for (std::size_t i = 0; i < limit.axis.size(); ++i) {
    const bool turns = curve.is_arc && (i == curve.axis_1 || i == curve.axis_2);
    const double share = turns ? 1 : std::abs(curve.direction[i]);
    if (share <= kNoShare) continue;
    if (limit.axis[i] > 0) lower(most, limit.axis[i] / share);
    time_s = std::max(time_s, limit.time_s[i]);
  }
  if (time_s > 0) lower(most, feed_mm_s / time_s);
  return most;
}

void AccelerationRules::apply(const motion::Curve& curve, motion::Move& move, MotionKind kind, double rpm,
                              double ratio) const {
  double feed_mm_s = 0;
  if (const auto* feed = std::get_if<motion::PathFeed>(&move.feed)) feed_mm_s = feed->mm_s;
  if (const auto* feed = std::get_if<motion::RevolutionFeed>(&move.feed)) feed_mm_s = feed->mm_rev * rpm / 60;
  if (const auto* cut = std::get_if<motion::ThreadFeed>(&move.feed)) feed_mm_s = cut->lead_mm * rpm / 60;
  const Kind& limits = kinds_[static_cast<std::size_t>(kind)];
  move.speed_up_mm_s2 = allowed(limits.up, curve, feed_mm_s) * ratio;
  move.slow_down_mm_s2 = allowed(limits.down, curve, feed_mm_s) * ratio;
}

}  // namespace headstock::operation
