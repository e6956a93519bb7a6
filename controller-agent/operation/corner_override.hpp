// Inner corners under G62 and cutter compensation: the feed is reduced from a distance before the corner to a
// distance behind it (0i-D 5.4.2.1, L5030-L5153; No. 1711-1714). Stands between MotionFeed and the kernel,
// keeps back what a corner that is not known yet could still slow, and cuts moves where the feed changes.
// Look-ahead thread.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>

#include "interpreter/canonical.hpp"
#include "interpreter/machine_data.hpp"
#include "motion/geometry.hpp"
#include "operation/overtravel_alarm.hpp"

namespace headstock::operation {

using machine::AxisVector;

/// What the parameters say.
struct CornerOverrideRules {
  double ratio = 1;       ///< of the feed at an inner corner (No. 1712)
  double widest_rad = 0;  ///< of the angle between the two paths that is an inner corner (No. 1711)
  double before_mm = 0;   ///< straight distance from the corner where it begins (No. 1713), >= 0
  double after_mm = 0;    ///< … and where it ends (No. 1714), >= 0
  bool valid = false;     ///< No. 1711 is 2°…178° and No. 1712 is 1…100 %

  static CornerOverrideRules read(const interp::MachineData& data);
};

/// On which side of its path the tool cuts, as far as a corner's feed depends on it.
struct CuttingSide {
  std::int8_t side = 0;  ///< +1 the tool is left of the path (G41), -1 right (G42), 0: nothing is reduced
  std::uint8_t axis_1 = 0, axis_2 = 1;  ///< of the plane

  /// Of a move, positioning too; side 0 unless G62 and G41 or G42 are in force.
  static CuttingSide of(const interp::Motion& motion, const machine::Machine& machine);
  bool operator==(const CuttingSide&) const = default;
};

/// PS0148 for a move under G62 and compensation when the parameters are out of range (0i-D L71918).
std::optional<MachineAlarm> corner_override_alarm(const CuttingSide& side, const CornerOverrideRules& rules);

class CornerOverride {
 public:
  using Sink = std::function<void(const AxisVector& start, const motion::Move& move)>;

  /// @param axes of the machine; @param sink gets the moves in order, cut where the feed changes
  CornerOverride(std::size_t axes, Sink sink) : axes_(axes), sink_(std::move(sink)) {}

  void set_rules(const CornerOverrideRules& rules) { rules_ = rules; }
  /// Nothing is kept back, nothing was before.
  void reset();
  /// @param side of what cuts; 0 under look-ahead control, where the override does not act (0i-D L5141)
  void add(const AxisVector& start, const motion::Move& move, const CuttingSide& side);
  /// The next move is not known: everything kept back goes on its way.
  void release();
  /// Moves that release() would hand over at most.
  std::size_t kept() const { return kept_.size(); }

 private:
  struct Kept {
    AxisVector start;
    motion::Move move;
    motion::Curve curve;
    bool takes_part = true;
    bool slowed = false;
  };

  bool is_inner(const motion::Curve& from, const motion::Curve& to) const;
  void slow_before(const AxisVector& corner);
  /// The part of the newest move inside the distance behind the corner that is being left.
  void slow_after();
  /// Length at which the distance from `corner` first exceeds `distance`, from the end or the beginning on.
  double length_at(const motion::Curve& curve, const AxisVector& corner, double distance,
                   bool from_end) const;
  /// Cuts kept_[index] in two at this length; nothing to cut at its ends.
  bool cut(std::size_t index, double length);
  void slow(Kept& kept) const;

  std::size_t axes_;
  Sink sink_;
  CornerOverrideRules rules_;
  std::deque<Kept> kept_;
  CuttingSide side_;                     // of the newest
  bool started_ = false;                 // the newest is not the start-up of the compensation
  std::optional<motion::Curve> before_;  // the newest, when it cuts
  std::optional<AxisVector> behind_;     // the corner that is being left
};

}  // namespace headstock::operation
