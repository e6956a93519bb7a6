// Where a program is, as it is kept on the disk, and what a restart in its middle needs. Plain data.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "interpreter/canonical.hpp"

namespace headstock::operation {

/// The block of a program from the memory that is being carried out. On the disk it may be older than the
/// machine, never younger: everything before it has been carried out.
struct Breakpoint {
  std::string program, revision_hash;  ///< empty: none
  std::uint32_t block = 0;             ///< SourcePosition::block; 0: nothing has begun
  std::uint32_t sequence = 0;          ///< last N passed
  std::uint32_t line = 0;              ///< of the program the block is in

  bool operator==(const Breakpoint&) const = default;
};

/// What the part of a program before a restart would have done; for the operator.
struct RestartReport {
  bool found = false;
  std::uint32_t block = 0, sequence = 0;
  std::vector<std::int32_t> m;  ///< M codes passed, the newest 35, oldest first
  std::int32_t tool = 0, offset = 0;
  double spindle = 0;              ///< S in force
  int turning = 0;                 ///< 1 clockwise (M03), -1 counterclockwise (M04), 0 stopped
  machine::AxisVector position{};  ///< machine coordinates where the axes will be taken [mm, degrees]
};

}  // namespace headstock::operation
