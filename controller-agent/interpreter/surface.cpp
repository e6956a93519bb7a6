// G07.1 and G12.1/G13.1: entering and leaving the modes, and what may be commanded in them.
#include "interpreter/surface.hpp"

#include <bit>
#include <cmath>
#include <numbers>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kAtPole_mm = 1e-7;  // closer to the pole there is no direction

// Codes a program may give in either mode (0i-D 4.5, PS0146, PS0176). Those that are something else in
// another G-code system count only where they are settings.
constexpr std::int16_t kAllowed[] = {10,  20,  30,  40,  71,  90,  121, 131, 390, 400, 410,  420,  610, 640,
                                     650, 660, 670, 900, 910, 940, 950, 970, 980, 990, 1070, 1120, 1130};
constexpr std::int16_t kOnlySettings = 670;

}  // namespace

AxisVector Surface::to_machine(const AxisVector& plane, double near_deg) const {
  AxisVector machine = plane;
  if (kind == SurfaceKind::cylinder) {
    machine[rotary] = plane[rotary] / mm_per_degree;
    return machine;
  }
  const double along = side * (plane[linear] - pole), across = side * plane[rotary];
  const double radius = std::hypot(along, across);
  machine[linear] = pole + side * radius;
  const double angle = radius < kAtPole_mm ? near_deg : std::atan2(across, along) / kDegree + zero_deg;
  machine[rotary] = near_deg + std::remainder(angle - near_deg, 360.0);
  return machine;
}

AxisVector Surface::to_plane(const AxisVector& machine) const {
  AxisVector plane = machine;
  if (kind == SurfaceKind::cylinder) {
    plane[rotary] = machine[rotary] * mm_per_degree;
    return plane;
  }
  const double radius = machine[linear] - pole;
  const double angle = (machine[rotary] - zero_deg) * kDegree;
  plane[linear] = pole + radius * std::cos(angle);
  plane[rotary] = radius * std::sin(angle);
  return plane;
}

void Surface::show(Motion& motion, const AxisVector& machine) const {
  motion.modal.work_zero[rotary] = work_zero_deg;
  motion.end_machine = machine;
  for (const std::size_t i : {rotary, linear})
    motion.end_work[i] = (machine[i] - motion.modal.work_zero[i]) / mm_per_unit[i];
}

// The rotary axis in the mode's units, its state before kept.
void Executor::enter_surface(const Surface& wanted, double unit_in_mm) {
  ProgramAxis& axis = axes[wanted.rotary];
  SurfaceMode& m = surface;
  m.now = wanted;
  m.now.work_zero_deg = modal.work_zero[wanted.rotary];
  for (std::size_t i = 0; i < axes.size(); ++i) m.now.mm_per_unit[i] = axes[i].mm_per_unit;
  m.saved_mm_per_unit = axis.mm_per_unit;
  m.saved_diameter = axis.diameter;
  m.saved_increment = axis.increment;
  m.saved_rotary = axis.rotary;
  m.saved_rolls_over = axis.rolls_over;
  m.saved_plane = plane;
  m.saved_first = plane_index.first;
  m.saved_second = plane_index.second;
  double* const zeros[] = {&axis.zero_external, &axis.zero_work, &axis.zero_shift, &axis.zero_local,
                           &axis.zero_tool};
  for (std::size_t i = 0; i < std::size(zeros); ++i) m.saved_zeros[i] = *zeros[i];
  axis.rolls_over = false;
  axis.mm_per_unit = unit_in_mm;
  surface_path.rotary_deg = machine_now[wanted.rotary];
}

void Executor::leave_surface() {
  if (surface.now.kind == SurfaceKind::none) return;
  const Surface was = surface.now;
  SurfaceMode& m = surface;
  const AxisVector place = was.to_machine(machine_now, surface_path.rotary_deg);
  ProgramAxis& axis = axes[was.rotary];
  axis.mm_per_unit = m.saved_mm_per_unit;
  axis.diameter = m.saved_diameter;
  axis.increment = m.saved_increment;
  axis.rotary = m.saved_rotary;
  axis.rolls_over = m.saved_rolls_over;
  double* const zeros[] = {&axis.zero_external, &axis.zero_work, &axis.zero_shift, &axis.zero_local,
                           &axis.zero_tool};
  for (std::size_t i = 0; i < std::size(zeros); ++i) *zeros[i] = m.saved_zeros[i];
  modal.work_zero[was.rotary] = was.work_zero_deg;
  m.now.kind = SurfaceKind::none;
  if (was.kind == SurfaceKind::polar) {
    plane = m.saved_plane;
    plane_index = {m.saved_first, m.saved_second};
  }
  for (std::size_t i = 0; i < axes.size(); ++i) set_axis_machine(i, place[i]);
}

AxisVector Executor::place_in_plane(const AxisVector& machine_position) {
  if (surface.now.kind == SurfaceKind::none) return machine_position;
  surface_path = {};
  surface_path.rotary_deg = machine_position[surface.now.rotary];
  return surface.from = surface.now.to_plane(machine_position);
}

// A block of the mode: only codes that make sense in the plane, and moves that are no rapids.
bool Executor::surface_allows() {
  const bool polar_mode = surface.now.kind == SurfaceKind::polar;
  const AlarmReason reason = polar_mode ? AlarmReason::polar_code : AlarmReason::cylinder_code;
  for (std::size_t i = 0; i < block.g_count; ++i) {
    const GCode* row = table->find(block.g[i].tenths);
    bool fits = false;
    for (const std::int16_t code_allowed : kAllowed) fits = fits || code_allowed == block.g[i].tenths;
    const bool plane_code = block.g[i].tenths >= 170 && block.g[i].tenths <= 190;
    fits = fits || (plane_code && !polar_mode && dialect.modes.free_surfaces);
    if (fits && row->tenths > kOnlySettings && row->tenths < 1000) fits = row->phase == Phase::setting;
    if (!fits) return alarm(reason, block.g[i], 'G');
  }
  if (block.has('T') && !switches.lenient) return alarm(reason, block['T'].column, "T");
  const bool moves = action == nullptr && (block.words & axis_letters) != 0;
  bool plane_follows = false;  // the block itself chooses the arc's plane
  for (std::size_t i = 0; i < block.g_count; ++i)
    plane_follows = plane_follows || (block.g[i].tenths >= 170 && block.g[i].tenths <= 190);
  if (moves && motion_code->tenths != 10 && motion_code->tenths != 20 && motion_code->tenths != 30)
    return alarm(reason, 0, std::string(motion_code->name));
  if (!polar_mode && moves &&
      motion_code->tenths != 10) {  // arcs on a cylinder: by R only, in a plane with the axis
    const std::uint32_t centre = block.words & program::letters("IJK");
    if (centre != 0 && !dialect.modes.free_surfaces) {
      const char letter = static_cast<char>('A' + std::countr_zero(centre));
      return alarm(reason, block[letter].column, std::string(1, letter));
    }
    const auto rotary = static_cast<int>(surface.now.rotary);
    if (!plane_follows && plane_index.first != rotary && plane_index.second != rotary)
      return alarm(AlarmReason::cylinder_axis, 0, std::string(1, axes[surface.now.rotary].name));
  }
  return true;
}

// Moves of the plane become moves of the machine; everything else passes with the true zero point.
Pull Executor::next_on_machine(Operation& wanted) {
  if (surface_path.pieces_left()) {
    surface_path.piece(wanted);
    return Pull::operation;
  }
  const Pull pulled = normal_direction.pull(*this, wanted);
  if (pulled != Pull::operation || surface.last.kind == SurfaceKind::none) return pulled;
  const Motion* motion = nullptr;
  if (const auto* feed = std::get_if<Feed>(&wanted)) motion = feed;
  if (const auto* arc = std::get_if<Arc>(&wanted)) motion = arc;
  if (motion != nullptr && motion->in_plane) {
    const AxisVector end = motion->end_machine;
    const Operation move = std::move(wanted);
    surface_path.begin(surface.last, move, surface.from);
    surface.from = end;
    surface_path.piece(wanted);
  } else if (surface.now.kind != SurfaceKind::none) {
    std::visit(
        [this](auto& op) {
          if constexpr (requires { op.modal; })
            op.modal.work_zero[surface.now.rotary] = surface.now.work_zero_deg;
        },
        wanted);
  }
  return pulled;
}

const ModalSnapshot& Executor::modal_on_machine() {
  if (surface.now.kind == SurfaceKind::none) return modal;
  shown_modal = modal;
  shown_modal.work_zero[surface.now.rotary] = surface.now.work_zero_deg;
  return shown_modal;
}

namespace handlers {

// G07.1 C r: on; G07.1 C0: off.
bool cylinder(Executor& ex) {
  const std::uint32_t words = ex.block.words & ex.axis_letters;
  if (std::popcount(words) != 1)
    return ex.alarm(AlarmReason::cylinder_axis, ex.code_column, std::string(ex.code->name));
  const auto letter = static_cast<unsigned>(std::countr_zero(words));
  const program::Word& word = ex.block.word[letter];
  const auto index = static_cast<std::size_t>(ex.axis_of[letter]);
  const std::string name(1, static_cast<char>('A' + letter));
  const double radius = ex.length_mm(word);
  const bool on = ex.surface.now.kind == SurfaceKind::cylinder;
  if (on && ex.surface.now.rotary != index) return ex.alarm(AlarmReason::cylinder_axis, word.column, name);
  if (radius == 0) {
    ex.leave_surface();
    return true;
  }
  const bool by_rapid = ex.motion_code->tenths == 0 && !ex.dialect.modes.free_surfaces;
  if (on || by_rapid || !ex.compensation_is_off())
    return ex.alarm(AlarmReason::cylinder_code, ex.code_column, std::string(ex.code->name));
  ProgramAxis& axis = ex.axes[index];
  if (!axis.rotary || radius < 0) return ex.alarm(AlarmReason::cylinder_axis, word.column, name);
  Surface wanted;
  wanted.kind = SurfaceKind::cylinder;
  wanted.rotary = wanted.linear = index;
  wanted.mm_per_degree = radius * kDegree;
  // The axis is written in degrees (0i-D); as a length on the cylinder by the K2000TC (its example L3598).
  ex.enter_surface(wanted, ex.dialect.modes.free_surfaces ? ex.unit_mm : wanted.mm_per_degree);
  for (double* zero :
       {&axis.zero_external, &axis.zero_work, &axis.zero_shift, &axis.zero_local, &axis.zero_tool})
    *zero *= wanted.mm_per_degree;
  ex.modal.work_zero[index] *= wanted.mm_per_degree;
  ex.set_axis_machine(index, ex.machine_now[index] * wanted.mm_per_degree);
  ex.surface.last = ex.surface.now;
  ex.surface.from = ex.machine_now;
  return true;
}

// G12.1: the linear axis and the rotary axis span a plane; the rotary axis' words are millimetres in it.
bool polar_interpolation_on(Executor& ex) {
  const auto& rules = ex.dialect.modes;
  const std::uint32_t column = ex.code_column;
  const std::string name(ex.code->name);
  if (ex.surface.now.kind != SurfaceKind::none || !ex.compensation_is_off())
    return ex.alarm(AlarmReason::polar_code, column, name);
  for (const auto parameter : rules.polar_unsupported) {
    if (ex.data.parameter(parameter) != 0)
      return ex.alarm(AlarmReason::g_unavailable, column, name + " No." + std::string(parameter));
  }
  // Axis numbers by parameter; without one X and the C axis.
  const auto axis_by = [&ex](std::string_view parameter, char otherwise) -> int {
    const auto number = static_cast<int>(ex.data.parameter(parameter));
    if (number != 0) return number >= 1 && number <= static_cast<int>(ex.axes.size()) ? number - 1 : -1;
    const auto named = ex.axis_named(otherwise);
    return named ? static_cast<int>(*named) : -1;
  };
  return enter_polar(ex, axis_by(rules.polar_linear_parameter, 'X'),
                     axis_by(rules.polar_rotary_parameter, 'C'));
}

// The mode on these axes; -1: the machine has none.
bool enter_polar(Executor& ex, int linear, int rotary) {
  const std::uint32_t column = ex.code_column;
  const std::string name(ex.code->name);
  if (linear < 0 || rotary < 0 || linear == rotary || ex.axes[static_cast<std::size_t>(linear)].rotary ||
      !ex.axes[static_cast<std::size_t>(rotary)].rotary)
    return ex.alarm(AlarmReason::polar_axis, column, name);
  Surface wanted;
  wanted.kind = SurfaceKind::polar;
  wanted.linear = static_cast<std::size_t>(linear);
  wanted.rotary = static_cast<std::size_t>(rotary);
  wanted.pole = ex.modal.work_zero[wanted.linear];
  wanted.side = ex.machine_now[wanted.linear] < wanted.pole ? -1 : 1;
  wanted.zero_deg = ex.machine_now[wanted.rotary];
  ex.enter_surface(wanted, ex.unit_mm);
  ProgramAxis& axis = ex.axes[wanted.rotary];
  axis.rotary = false;
  axis.diameter = 1;
  axis.increment = ex.linear_increment;
  axis.zero_external = axis.zero_work = axis.zero_shift = axis.zero_local = axis.zero_tool = 0;
  ex.modal.work_zero[wanted.rotary] = 0;
  ex.set_axis_machine(wanted.rotary, 0);  // the plane's second coordinate is 0 where the mode begins
  ex.plane = Plane::xy;
  ex.plane_index = {linear, rotary};
  ex.surface.last = ex.surface.now;
  ex.surface.from = ex.machine_now;
  return true;
}

bool polar_interpolation_off(Executor& ex) {
  if (ex.surface.now.kind != SurfaceKind::polar) return true;
  if (!ex.compensation_is_off())
    return ex.alarm(AlarmReason::polar_code, ex.code_column, std::string(ex.code->name));
  ex.leave_surface();
  return true;
}

}  // namespace handlers
}  // namespace headstock::interp
