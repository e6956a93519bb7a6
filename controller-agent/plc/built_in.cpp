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
      break;
    case FunctionKind::m:
      for (const Coolant& coolant : kCoolant) {
        if (coolant.code != request.code) continue;
        outputs_.mist = coolant.mist;
        outputs_.coolant = coolant.flood;
      }
      break;
    case FunctionKind::tool:
      outputs_.tool = request.code;
      break;
  }
}

void BuiltIn::step(const Inputs& inputs) noexcept {
  if (finished_) return;
  remaining_s_ -= inputs.period_s;
  const bool waits_for_spindle = request_.kind == FunctionKind::spindle && !inputs.spindle_at_speed;
  finished_ = remaining_s_ <= 1e-9 && !waits_for_spindle;
}

void BuiltIn::reset() noexcept {
  finished_ = true;
  const auto tool = outputs_.tool;
  outputs_ = {};
  outputs_.tool = tool;
}

}  // namespace headstock::plc
