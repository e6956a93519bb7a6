// Profiles N p … N q of G70-G73: found in the program, read by carrying their blocks out without motion (so
// that macros, corners and every number form mean what they mean when cut), and cut by G70.
#pragma once

#include <cstdint>

#include "cycles/geometry.hpp"
#include "cycles/rules.hpp"
#include "interpreter/executor.hpp"

namespace headstock::cycles {

/// P and Q of the block.
struct BlockRange {
  std::uint32_t first = 0, last = 0;
};

struct Profile {
  Point start;                                        ///< where the tool stands when the cycle begins
  Path segments;                                      ///< all moves, the approach A → A' included
  std::size_t approach = 0;                           ///< how many of them are the first block's
  bool first_moves_u = false, first_moves_v = false;  ///< axes of the first block
  bool first_rapid = true;
};

/// Reads P and Q. @return false after an alarm.
bool take_range(interp::Executor& ex, const Rules& rules, BlockRange& range);

/// Reads the profile ahead. Afterwards the program goes on behind it (or behind the cycle's block when the
/// profile stands before it) and the modal state is what it was. @return false after an alarm.
bool read_profile(interp::Executor& ex, const Rules& rules, BlockRange range, Profile& profile);

/// Starts cutting the profile: its blocks are carried out next, then the tool returns rapidly to where it
/// stands now.
bool start_finishing(interp::Executor& ex, const Rules& rules, BlockRange range);

/// Raises the controller's alarm for a fault. Always returns false.
bool fail(interp::Executor& ex, const Rules& rules, Fault fault, char letter, std::string detail = {});

/// The plane's axes as indices of the machine's axes. @return false after an alarm.
struct PlaneAxes {
  std::size_t u = 0, v = 0;
  char u_name = 'Z', v_name = 'X', u_step = 'W', v_step = 'U';
};
bool plane_axes(interp::Executor& ex, const Rules& rules, PlaneAxes& axes);

}  // namespace headstock::cycles
