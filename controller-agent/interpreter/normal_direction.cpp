#include "interpreter/normal_direction.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp {
namespace {

constexpr std::int16_t kLeft = 411, kRight = 421;
constexpr double kSameAngle_deg = 1e-4;
constexpr double kNoTurnMove_mm = 1e-6;
constexpr double kFastest_deg_min = 15'000;
constexpr double kDegree = std::numbers::pi / 180;

std::size_t group_of(const Executor& ex) {
  const GCode* code = ex.table->find(kLeft);
  return code != nullptr ? code->group : 0;
}

}  // namespace

bool NormalDirection::begin(Executor& ex) {
  const auto wrong = [&ex](AlarmReason reason, std::string detail) {
    return ex.alarm(reason, ex.code_column, std::move(detail));
  };
  // Where the tool really stands is not known while a corner waits for its next block.
  if (ex.pipeline.compensating() || ex.pipeline.holds_corner())
    return wrong(AlarmReason::g_not_now, "G41, G42, chamfer");
  const double number = ex.data.parameter("5480");
  if (!(number >= 1) || number > static_cast<double>(ex.axes.size()))
    return wrong(AlarmReason::normal_direction, "5480");
  const auto axis = static_cast<std::size_t>(number) - 1;
  if (!ex.axes[axis].rotary || ex.role_of(axis) != 0) return wrong(AlarmReason::normal_direction, "5480");
  feed_deg_min_ = ex.data.parameter("5481");
  if (!(feed_deg_min_ >= 1) || feed_deg_min_ > kFastest_deg_min)
    return wrong(AlarmReason::normal_direction, "5481");
  least_mm_ = ex.data.parameter("5483") * ex.unit_mm;
  if (on_ && axis != axis_) return wrong(AlarmReason::normal_direction, "5480");
  if (on_) return true;
  axis_ = axis;
  on_ = known_ = true;
  last_machine_ = ex.machine_now;
  last_work_ = ex.work_now;
  angle_deg_ = ex.machine_now[axis];
  return true;
}

bool NormalDirection::end(Executor& ex) {
  if (!on_) return true;
  if (ex.pipeline.compensating() || ex.pipeline.holds_corner())
    return ex.alarm(AlarmReason::g_not_now, ex.code_column, "G41, G42, chamfer");
  on_ = false;
  ex.set_axis_machine(axis_, angle_deg_);
  return true;
}

void NormalDirection::stand(const Executor& ex) {
  waiting_ = false;
  if (!known_) return;
  const std::int16_t mode = ex.modal.g[group_of(ex)];
  on_ = mode == kLeft || mode == kRight;  // RESET may have taken a G41.1 back, or a G40.1
  if (!on_) return;
  last_machine_ = ex.machine_now;
  last_work_ = ex.work_now;
  angle_deg_ = ex.machine_now[axis_];
}

Pull NormalDirection::pull(Executor& ex, Operation& out) {
  if (waiting_) {
    waiting_ = false;
    out = std::move(next_);
    return Pull::operation;
  }
  const Pull pulled = ex.next(out);
  if (!on_ || pulled != Pull::operation || motion_in(out) == nullptr) return pulled;
  if (turn(ex, out)) {
    next_ = std::move(out);
    out = std::move(alone_);
    waiting_ = true;
  }
  return pulled;
}

void NormalDirection::show(const Executor& ex, Motion& motion) const {
  motion.end_machine[axis_] = angle_deg_;
  const double work = (angle_deg_ - motion.modal.work_zero[axis_]) / ex.axes[axis_].mm_per_unit;
  motion.end_work[axis_] = ex.within_turn(axis_, work);
}

bool NormalDirection::turn(const Executor& ex, Operation& move) {
  Motion& motion = *motion_in(move);
  const auto* const rapid = std::get_if<Rapid>(&move);
  auto* const arc = std::get_if<Arc>(&move);
  const std::uint32_t bit = 1u << axis_;
  const double from_x = last_machine_[0], from_y = last_machine_[1];
  const auto passed = [&] {
    last_machine_ = motion.end_machine;
    last_work_ = motion.end_work;
  };
  const bool to_machine = rapid != nullptr && rapid->machine_coordinates;
  if (to_machine && (motion.axes & bit) != 0) {  // G28, G53 of the axis itself
    angle_deg_ = motion.end_machine[axis_];
    passed();
    return false;
  }
  double first_deg = 0, swept_deg = 0, size = 0;
  if (arc == nullptr) {
    const double dx = motion.end_machine[0] - from_x, dy = motion.end_machine[1] - from_y;
    first_deg = std::atan2(dy, dx) / kDegree;
    size = std::hypot(dx, dy);
  } else if (arc->plane == Plane::xy) {
    const double sense = arc->turn == Turn::ccw ? 1 : -1;
    first_deg =
        std::atan2(from_y - arc->center_machine[1], from_x - arc->center_machine[0]) / kDegree + sense * 90;
    swept_deg = sense * arc->turns * 360;
    size = 2 * arc->radius_mm;
  }
  bool alone = false;
  if (size > kNoTurnMove_mm && size >= least_mm_ && !to_machine) {
    const double ahead = motion.modal.g[group_of(ex)] == kLeft ? 90 : -90;
    const double by = std::remainder(first_deg + ahead - angle_deg_, 360.0);
    if (std::fabs(by) > kSameAngle_deg) {
      alone = true;
      angle_deg_ += by;
      Motion turned = motion;
      turned.end_machine = last_machine_;
      turned.end_work = last_work_;
      turned.axes = bit;
      show(ex, turned);
      if (rapid != nullptr) {
        static_cast<Motion&>(alone_.emplace<Rapid>()) = turned;
      } else {
        Feed& feed = alone_.emplace<Feed>();
        static_cast<Motion&>(feed) = turned;
        feed.feed = feed_deg_min_;
      }
    }
    if (arc != nullptr) {
      angle_deg_ += swept_deg;
      motion.axes |= bit;
      arc->feed_on_arc = true;  // F is the tool's way, the angle goes along
    }
  }
  show(ex, motion);
  passed();
  return alone;
}

namespace handlers {

bool normal_direction_on(Executor& ex) {
  return ex.normal_direction.begin(ex);
}
bool normal_direction_off(Executor& ex) {
  return ex.normal_direction.end(ex);
}

}  // namespace handlers
}  // namespace headstock::interp
