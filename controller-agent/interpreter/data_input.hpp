// G10: data a program writes.
#pragma once

#include <cstdint>
#include <string>

namespace headstock::interp {

struct Executor;

/// G10 L3, L50, L52: the blocks up to G11 are data, not motion.
struct DataInputMode {
  /// Takes one block of data; nullptr outside the mode. @return false after an alarm. A block with G11 does
  /// not get here: it ends the mode, after `finish`.
  bool (*line)(Executor&) = nullptr;
  /// Called at G11; may be nullptr. @return false after an alarm.
  bool (*finish)(Executor&) = nullptr;
};

/// An offset that a G10 wrote while motions in front of it were held (G41/G42): RESET may have to take it back.
struct DataInputAhead {
  std::uint32_t block = 0;  ///< SourcePosition::block of the G10
  std::string what;         ///< see data_values.hpp
  double before = 0, after = 0;
};

}  // namespace headstock::interp
