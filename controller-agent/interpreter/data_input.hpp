// G10: data a program writes.
#pragma once

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

}  // namespace headstock::interp
