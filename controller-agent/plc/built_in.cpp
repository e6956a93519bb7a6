#include "plc/built_in.hpp"

namespace headstock::plc {
namespace {

struct Coolant {
  std::int32_t code;
  bool mist, flood;
};
constexpr Coolant kCoolant[] = {{7, true, false}, {8, false, true}, {9, false, false}};

}  // namespace

void BuiltIn::request(const Request& request) noexcept {
  request_ = request;
  finished_ = false;
  remaining_s_ = request.kind == FunctionKind::tool ? times_.tool_s : times_.m_s;
  switch (request.kind) {
    case FunctionKind::spindle:
      outputs_.turning = request.turning;
      outputs_.speed = request.speed;
      outputs_.constant_surface_speed = request.constant_surface_speed;
      outputs_.clamp_rpm = request.clamp_rpm;
      outputs_.surface_axis = request.surface_axis;
      outputs_.orient = outputs_.contour = false;
      ++outputs_.spindle_orders;
      break;
    case FunctionKind::m:
      if (request.code != 0 && request.code == codes_.orient) place_spindle(true, false);
      if (request.code != 0 && request.code == codes_.contour_on) place_spindle(false, true);
      if (request.code != 0 && request.code == codes_.contour_off) place_spindle(false, false);
      for (const Coolant& coolant : kCoolant) {
        if (coolant.code != request.code) continue;
        outputs_.mist = coolant.mist;
        outputs_.coolant = coolant.flood;
      }
      break;
    case FunctionKind::tool:
      outputs_.tool = request.code;
      break;
    case FunctionKind::second_auxiliary:
      outputs_.second_auxiliary = request.code;
      break;
  }
}

void BuiltIn::place_spindle(bool orient, bool contour) noexcept {
  outputs_.turning = Turning::stop;
  outputs_.orient = orient;
  outputs_.contour = contour;
  ++outputs_.spindle_orders;
}

void BuiltIn::step(const Inputs& inputs) noexcept {
  if (finished_) return;
  remaining_s_ -= inputs.period_s;
  const bool waits_for_spindle = request_.kind == FunctionKind::spindle && !inputs.spindle_at_speed;
  const bool turns_to_angle = request_.kind == FunctionKind::m && outputs_.orient && !inputs.spindle_oriented;
  const bool couples = request_.kind == FunctionKind::m && outputs_.contour && !inputs.contour_ready;
  finished_ = remaining_s_ <= 1e-9 && !waits_for_spindle && !turns_to_angle && !couples;
}

void BuiltIn::reset() noexcept {
  finished_ = true;
  const Outputs before = outputs_;
  outputs_ = {};
  outputs_.tool = before.tool;
  outputs_.spindle_orders = before.spindle_orders + 1;
}

}  // namespace headstock::plc
