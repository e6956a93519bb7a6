// What a dialect says about the way tool offsets are carried out and measured: parameters by the manual's
// number; an empty one does not exist there.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace headstock::dialects {

/// How the offset of a T word (lathe) or of G43/G44 (mill) takes effect.
///   by shift     the coordinate system moves, the slides stay (the position page changes)
///   by movement  the slides move by the change, the position page stays
struct ToolOffsetRules {
  bool by_shift = true;                      ///< without a parameter
  std::string_view shift_parameter;          ///< bit: geometry and wear by shift …
  double shift_default = 0;                  ///< … this when it is not set
  std::string_view wear_shift_parameter;     ///< bit: wear by shift; 0: by movement (0i-T LWT)
  std::string_view geometry_move_parameter;  ///< bit: geometry by movement (0i-T LGT)
  /// Bit: a movement waits for the next move of its axis; otherwise the T block itself moves (0i-T LWM).
  std::string_view with_next_move_parameter;
  bool moves_first = false;           ///< a movement is a rapid of its own, before the block's move (2000TC)
  std::string_view radius_parameter;  ///< bit: values of a diameter axis are radii (ORC)
  std::string_view
      wear_diameter_parameter;        ///< bit, with the one above: wear is a diameter all the same (OWD)
  std::string_view axis_parameter;    ///< bit an axis, 1 unless set: it has tool offsets (K2000TC OFL)
  std::string_view single_parameter;  ///< bit: no wear, one value a number (0i-T NGW)

  // ---- RESET
  bool reset_clears = false;                      ///< it cancels the offset …
  std::string_view reset_keeps_parameter;         ///< … unless this bit says otherwise (218T TOC)
  std::string_view reset_clears_wear_parameter;   ///< bit: wear, and all that is by movement (0i-T LVC)
  std::string_view reset_clears_shift_parameter;  ///< bit: geometry by shift (0i-T TGC)
  std::string_view reset_keeps_length_parameter;  ///< bit: G43/G44 stay (0i-M LVK)

  // ---- how many offsets there are: the first that applies
  std::string_view few_parameter;  ///< bit: the machine has only `few` (0i-D NDO)
  std::int64_t few = 0;

  // ---- G43 G44 G49 (mill)
  std::string_view normal_axis_parameter;   ///< bit: the axis normal to the plane (type B), otherwise Z (A)
  std::string_view named_axis_parameter;    ///< bit: the axis written in the block (type C)
  std::string_view several_axes_parameter;  ///< bit: type C on a second axis is no alarm (TAL)
  std::string_view at_once_parameter;       ///< bit: a changed value counts from the next block on (EVO)
};

/// G36 and G37: the tool is moved against a sensor and its offset corrected. By axis: X, Y, Z.
struct MeasureRules {
  std::array<std::string_view, 3> feed{};     ///< mm/min; not set: that of the first
  std::array<std::string_view, 3> gamma{};    ///< the feed begins this far before the place [mm]
  std::array<std::string_view, 3> epsilon{};  ///< the signal may come this far from it [mm]
  std::array<char, 2> axis{};                 ///< of G36 and G37; 0: the axis written
  std::string_view subtract_parameter;        ///< bit: the difference is subtracted (MDC)
  bool into_geometry = false;                 ///< wear is added to the geometry and cleared (K2000TC)
};

}  // namespace headstock::dialects
