// Curves that no single canonical operation describes: three-point arcs, spirals, arcs with an axis that only
// exists in the program. They leave as short feeds, one at a time, none further from the curve than a
// tolerance.
#pragma once

#include <cstdint>
#include <memory>

#include "interpreter/canonical.hpp"
#include "interpreter/space_curve.hpp"

namespace headstock::interp {
struct Executor;
}

namespace headstock::dialects::k2000tc {

using interp::Executor;

/// Half a micrometre: below the least command of the control and far below what its drives follow.
inline constexpr double kChordTolerance_mm = 0.0005;

inline constexpr std::uint8_t kNoAxis = 0xff;

class RunningCurve {
 public:
  interp::SpaceCurve curve;
  std::uint8_t cartesian[3] = {0, 1, 2};  ///< axes of curve's coordinates
  interp::AxisVector from{}, to{};        ///< programmed, slide mm relative to the work zero: also other axes
  interp::AxisVector end_position{};      ///< nano units of the target, exact
  std::uint32_t moved = 0;
  double feed = 0;
  interp::FeedUnit unit = interp::FeedUnit::mm_per_minute;
  interp::SourcePosition at;
  bool exact_stop = false;

  /// Emits the next chord. @return false when it was the last.
  bool next(Executor& ex);

 private:
  double turned_ = 0;
};

// Handlers.
bool three_point_arc(Executor& ex);        // G02.1
bool plane_archimedean_cw(Executor& ex);   // G02.2
bool plane_archimedean_ccw(Executor& ex);  // G03.2
bool space_archimedean_cw(Executor& ex);   // G02.3
bool space_archimedean_ccw(Executor& ex);  // G03.3
bool plane_logarithmic_cw(Executor& ex);   // G02.4
bool plane_logarithmic_ccw(Executor& ex);  // G03.4
bool space_logarithmic_cw(Executor& ex);   // G02.5
bool space_logarithmic_ccw(Executor& ex);  // G03.5
bool rapid(Executor& ex);                  // G00
bool feed(Executor& ex);                   // G01
bool arc_cw(Executor& ex);                 // G02
bool arc_ccw(Executor& ex);                // G03

}  // namespace headstock::dialects::k2000tc
