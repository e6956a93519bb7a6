// What the memory of programs and its files answer.
#pragma once

#include <string>

namespace headstock::link {

/// Why the memory refused; `reason` is a message key: "bad_name" "memory_full" "bad_hash" "running"
/// "not_found" "disk_full" "disk_error" "busy". Empty when it did not.
struct MemoryResult {
  std::string reason;
  bool ok() const { return reason.empty(); }
};

}  // namespace headstock::link
