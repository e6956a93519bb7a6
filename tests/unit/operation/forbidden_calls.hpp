// What the real-time cycle must not do, counted by call: memory, locks, waiting, system calls. The program
// that links forbidden_calls.cpp has its own pthread_mutex_lock, malloc, read … in front of the C library's,
// so that a lock deep inside another library is seen too, contended or not.
#pragma once

#include <cstdint>

namespace headstock {

/// Counts what this thread calls between its making and its end.
class ForbiddenCalls {
 public:
  ForbiddenCalls() noexcept;
  ~ForbiddenCalls();
  ForbiddenCalls(const ForbiddenCalls&) = delete;
  ForbiddenCalls& operator=(const ForbiddenCalls&) = delete;

  std::uint64_t count() const noexcept;
  /// Name of the last one; "" when there was none.
  const char* last() const noexcept;
  /// Sanitizers put their own functions there: nothing is counted then.
  static bool watched() noexcept;

 private:
  std::uint64_t before_;
};

}  // namespace headstock
