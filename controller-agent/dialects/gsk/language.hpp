// What the GSK lathes do beside the tables: S as a gear, M codes that are sub-programs.
#pragma once

#include <memory>
#include <string_view>

#include "interpreter/own_language.hpp"

namespace headstock::dialects::gsk {

/// Bit parameters; empty where the control has none. A spindle is taken as analog while its bit is not set to
/// 0.
struct SpindleRules {
  std::string_view analog;       ///< S is a speed; otherwise S1…S4 are gears
  std::string_view gear_change;  ///< 218T: M41-M44 change the gear
  std::string_view subprograms;  ///< 218T CM98: an unknown M code mm calls O90mm, S O91ss, T O92tt
  std::string_view stations;     ///< number of tool stations; not set: not checked
  std::string_view type_b, rolls_over, by_sign;  ///< rotary axes; the first two are set unless they are 0
};

std::unique_ptr<interp::OwnLanguage> make_language(const SpindleRules& rules);

/// G12, G13 of 2000TC: the second stroke zone, corners in P116-P119.
bool stroke_zone_on(interp::Executor& ex);
bool stroke_zone_off(interp::Executor& ex);

}  // namespace headstock::dialects::gsk
