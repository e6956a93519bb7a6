// How a control takes an interruption macro, as data. The M codes are in macro::Rules, or the dialect's own.
#pragma once

#include <string_view>

namespace headstock::dialects {

struct InterruptionRules {
  std::string_view between_parameter;  ///< bit: between blocks only (0i-D MIN 6003#2); otherwise inside them too
  std::string_view inside_parameter;   ///< bit: inside blocks (K2000TC INTT P4100.3); otherwise between them
  std::string_view level_parameter;    ///< bit: as long as the signal is on (TSE); otherwise its rising edge
  bool resets_modes = false;   ///< the program begins with the power-on codes (K2000TC L20720)
  bool repeats_block = false;  ///< a block broken off by a program that moved is carried out again, not left out
};

}  // namespace headstock::dialects
