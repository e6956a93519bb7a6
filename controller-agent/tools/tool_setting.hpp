// What a number typed on the tool offset page means: direct input, measured values, trial cuts. Pure
// functions, any thread; millimetres as the page shows them (X as a diameter where the axis is
// diameter-programmed). Whoever keeps the offsets stores the result.
#pragma once

namespace headstock::tools {

/// Which way an offset counts: shown = machine − zero − offset (all but the 200T), or + offset (200T).
enum class OffsetSign : int { subtracted = 1, added = -1 };

/// A tool touches a surface whose place is known.
struct Touch {
  double shown = 0;  ///< absolute position page while the tool touches
  double place = 0;  ///< what that place shall be called: a measured diameter or length, 0 for a face
  /// The offset of this number that is counted in `shown`; 0 when none is in force (T..00).
  double in_force = 0;
};

/// The new offset, so that the page shows `place` there (218T trial cut, number + 100, L714; 2000TC L8574; 0i-D
/// direct input; 200T D and L, L835).
double measured_offset(const Touch& touch, OffsetSign sign = OffsetSign::subtracted);

/// Fixed point: the tool stands where the reference tool stood when the relative page was cleared (218T L697,
/// 2000TC L8519). @param relative U or W now @param reference offset of the reference tool
double fixed_point_offset(double relative, double reference = 0);

/// U, V, W on the page: added to what is stored.
double corrected_offset(double stored, double correction);

/// The 200T's trim of a part that came out too large or too small: U and W are the change of the *part* (L1307).
double trimmed_offset(double stored, double part_change);

}  // namespace headstock::tools
