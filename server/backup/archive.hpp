// A backup is one file: a tar, compressed with zstd, whose last entry `manifest.json` names every other with its size and
// SHA-256. Written beside its name and put in place only when it is whole and on the disk. Worker threads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace headstock::backup {

inline constexpr const char* kManifest = "manifest.json";
inline constexpr int kFormat = 1;

class ArchiveWriter {
 public:
  /// Throws db::Error{disk_full, unreadable}, as all of these.
  explicit ArchiveWriter(const std::filesystem::path& file);
  ~ArchiveWriter();  ///< without finish() nothing stays
  ArchiveWriter(const ArchiveWriter&) = delete;
  ArchiveWriter& operator=(const ArchiveWriter&) = delete;
  void add(const std::string& name, std::string_view bytes);
  /// @param sha256 what its content must be; empty: whatever it is. A file that has changed throws db::Error{corrupt}.
  void add_file(const std::string& name, const std::filesystem::path& file, const std::string& sha256 = {});

  struct Finished {
    std::string sha256;  ///< of the whole file
    std::uint64_t bytes = 0;
  };
  /// @param about goes into the manifest: kind, made, by …
  Finished finish(nlohmann::json about);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// One entry while it is being read.
class Entry {
 public:
  virtual ~Entry() = default;
  virtual const std::string& name() const = 0;
  virtual std::uint64_t bytes() const = 0;
  /// @return bytes written to `into`, 0 at the end.
  virtual std::size_t read(char* into, std::size_t at_most) = 0;
  /// The whole of it. Throws Refusal{damaged_backup} above the limit.
  std::string all(std::uint64_t limit = 64u << 20);
};

/// Reads everything and compares with the manifest. @return the manifest.
/// Throws Refusal{damaged_backup} (where: the entry), Refusal{not_a_backup}.
nlohmann::json verify(const std::filesystem::path& file);
/// Hands over every entry but the manifest, in order. For archives that verify() has passed.
void each_entry(const std::filesystem::path& file, const std::function<void(Entry&)>& entry);

}  // namespace headstock::backup
