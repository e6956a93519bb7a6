// Files of the program memory: durable writing, hashing, reading a program while it may be replaced. Private
// to link/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "link/memory_result.hpp"
#include "program/source.hpp"

namespace headstock::link {

/// A file descriptor that closes itself.
class File {
 public:
  File() = default;
  explicit File(int descriptor) : descriptor_(descriptor) {}
  ~File() { close(); }
  File(File&& other) noexcept : descriptor_(other.release()) {}
  File& operator=(File&& other) noexcept;
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  explicit operator bool() const { return descriptor_ >= 0; }
  int get() const { return descriptor_; }
  void close();

 private:
  int release() {
    const int descriptor = descriptor_;
    descriptor_ = -1;
    return descriptor;
  }
  int descriptor_ = -1;
};

File open_for_reading(const std::filesystem::path& path);
/// Writes all; "disk_full" or "disk_error" when it does not.
MemoryResult write_all(const File& file, std::string_view bytes);
/// Syncs the file, renames it over `to` and syncs the folder: after that a power cut cannot undo it.
MemoryResult rename_durably(const File& file, const std::filesystem::path& from,
                            const std::filesystem::path& to);
/// Writes a small file in one step (temporary, sync, rename).
MemoryResult replace_file(const std::filesystem::path& path, std::string_view text);
/// @return nullopt when the file cannot be read.
std::optional<std::string> hash_file(const std::filesystem::path& path);
std::unique_ptr<program::Source> source_from_file(File file);

}  // namespace headstock::link
