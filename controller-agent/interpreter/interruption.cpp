#include "interpreter/interruption.hpp"

#include <utility>

#include "interpreter/executor.hpp"

namespace headstock::interp {

/// What M99 of an interruption program brings back.
struct InterruptedState {
  ModalSnapshot modal;
  const GCode* motion_code = nullptr;
  bool incremental = false, exact_stop_mode = false, constant_surface_speed = false;
  FeedUnit feed_unit = FeedUnit::mm_per_minute;
  Plane plane = Plane::xy;
  double feed_mm = -1, rpm = 0, surface_speed = 0;
};

// M96 P, M97, and the codes that parameters put in their place.
bool Executor::allow_interruption(const program::Code& written, bool on) {
  interruption.enabled = on;
  if (!on) return true;
  if (!block.has('P')) return alarm(AlarmReason::call_without_p, written, 'M');
  const std::int64_t number = whole('P', AlarmReason::call_without_p);
  if (number < 0) return false;
  interruption.program = static_cast<std::uint32_t>(number);
  return true;
}

bool Executor::interrupting() const {
  for (const Frame& frame : frames)
    if (frame.macro.kind == CallKind::interruption) return true;
  return false;
}

bool Executor::interrupt(const AxisVector& machine_position, bool inside_block) {
  if (!interruption.enabled || finished || frames.empty() || interrupting()) return false;
  const auto refuse = [this](AlarmReason reason) {  // comes out with the next pull
    queue.emplace_back(
        Alarm{at, std::string(dialect.alarm_code(reason)), "O" + std::to_string(interruption.program)});
    finished = true;
    return true;
  };
  if (cycle.running != nullptr || cycle.watch != nullptr) return refuse(AlarmReason::interrupted_cycle);
  interruption.left_block = false;
  interruption.place_before = machine_now;
  interruption.inside = inside_block;
  set_position(machine_position);
  auto source = programs == nullptr ? nullptr : programs->open_number(interruption.program);
  if (source == nullptr) return refuse(AlarmReason::program_not_found);
  auto before = std::make_shared<InterruptedState>();
  *before = {modal, motion_code, incremental, exact_stop_mode, constant_surface_speed, feed_unit,
             plane, feed_mm,     rpm,         surface_speed};
  Frame& frame = push_program(std::move(source), interruption.program, 1);
  frame.macro.kind = CallKind::interruption;
  frame.macro.modal_calls.clear();  // G66 does not act in it (L20973)
  frame.macro.interrupted = std::move(before);
  if (dialect.interruption.resets_modes) power_on();
  interruption.acted = false;
  if (macros == nullptr) return true;
  macros->interrupted = modal_values();
  if (!data.bit(macros->rules.interruption_same_locals_parameter)) {
    frame.macro.locals = std::make_shared<macro::LocalSet>();
    macros->variables.locals = frame.macro.locals.get();
  }
  return true;
}

void Executor::end_interruption(const InterruptedState& before, bool keep_modal) {
  interruption.left_block = !interruption.acted;
  if (!interruption.acted) {
    set_position(interruption.place_before);  // the block it broke into goes on
  } else if (dialect.interruption.repeats_block && interruption.inside) {
    Frame& frame = frames.back();
    frame.rest = nullptr;
    frame.macro.next = frame.macro.last = nullptr;
    frame.macro.displaced = true;
    frame.macro.place = interruption.block;
  }
  if (keep_modal) return;  // M99 P: what the interruption program left stays (L20893)
  const ModalSnapshot now = modal;
  modal = before.modal;
  modal.work_zero = now.work_zero;
  modal.tool = now.tool;
  modal.offset = now.offset;
  if (modal.inch != now.inch) set_units(modal.inch);
  motion_code = before.motion_code;
  incremental = before.incremental;
  exact_stop_mode = before.exact_stop_mode;
  constant_surface_speed = before.constant_surface_speed;
  feed_unit = before.feed_unit;
  select_plane(before.plane);
  feed_mm = before.feed_mm;
  rpm = before.rpm;
  surface_speed = before.surface_speed;
}

}  // namespace headstock::interp
