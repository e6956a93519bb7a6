#include "interpreter/polar_command.hpp"

#include <cmath>
#include <numbers>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp {
namespace {

// The words of one axis: its absolute letter, or the letter of its increment.
const program::Word* word_of(const Executor& ex, std::size_t axis, std::uint32_t mask, bool& by) {
  for (unsigned letter = 0; letter < 26; ++letter) {
    if ((mask >> letter & 1u) == 0 || ex.axis_of[letter] != static_cast<std::int8_t>(axis)) continue;
    by = ex.incremental || (ex.incremental_letters >> letter & 1u) != 0;
    return &ex.block.word[letter];
  }
  return nullptr;
}

}  // namespace

// A radius counts from the work zero point when it is absolute and from where the tool stands when it is
// incremental; an incremental angle counts from the last one (0i-D appendix C; the manual common to both
// series does not go further).
bool Executor::take_polar(std::uint32_t& mask, std::uint32_t& moved) {
  const auto [index_1, index_2] = plane_axes();
  if (index_1 < 0 || index_2 < 0) return alarm(AlarmReason::arc_plane, code_column, "G16");
  const auto first = static_cast<std::size_t>(index_1), second = static_cast<std::size_t>(index_2);
  bool radius_by = false, angle_by = false;
  const program::Word* radius = word_of(*this, first, mask, radius_by);
  const program::Word* angle = word_of(*this, second, mask, angle_by);
  if (radius == nullptr && angle == nullptr) return true;
  const double at_1 = static_cast<double>(axes[first].position) / 1e9 * axes[first].mm_per_unit;
  const double at_2 = static_cast<double>(axes[second].position) / 1e9 * axes[second].mm_per_unit;
  if (!polar.known) {
    polar.center_1 = polar.center_2 = 0;
    polar.radius = std::hypot(at_1, at_2);
    polar.angle_deg = polar.radius > 0 ? std::atan2(at_2, at_1) * 180 / std::numbers::pi : 0;
    polar.known = true;
  }
  if (radius != nullptr) {
    if (!polar.fixed_pole) {
      polar.center_1 = radius_by ? at_1 : 0;
      polar.center_2 = radius_by ? at_2 : 0;
    }
    polar.radius = length_mm(*radius) + (polar.fixed_pole && radius_by ? polar.radius : 0);
  }
  if (angle != nullptr) {
    const double value = static_cast<double>(nano(*angle, program::kNano / 1000)) / 1e9;
    polar.angle_deg = angle_by ? polar.angle_deg + value : value;
  }
  const double radians = std::remainder(polar.angle_deg, 360.0) * std::numbers::pi / 180;
  const auto put = [this](std::size_t axis, double mm) {
    ProgramAxis& a = axes[axis];
    a.position = std::llround(mm / a.mm_per_unit * 1e9);
    // Where written digits are cut, a computed position is rounded all the same.
    if (dialect.numbers.rounding == dialects::Rounding::truncate)
      a.position =
          (a.position + (a.position < 0 ? -a.increment : a.increment) / 2) / a.increment * a.increment;
  };
  put(first, polar.center_1 + polar.radius * std::cos(radians));
  put(second, polar.center_2 + polar.radius * std::sin(radians));
  moved |= 1u << first | 1u << second;
  for (unsigned letter = 0; letter < 26; ++letter) {
    if (axis_of[letter] == index_1 || axis_of[letter] == index_2) mask &= ~(1u << letter);
  }
  return true;
}

namespace handlers {

bool polar_on(Executor& ex) {
  ex.polar.on = true;
  ex.polar.known = false;
  return true;
}

bool polar_off(Executor& ex) {
  ex.polar.on = false;
  return true;
}

}  // namespace handlers
}  // namespace headstock::interp
