// The data folder belongs to one server at a time.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "protocol/process/folder_lock.hpp"

namespace headstock::app {

/// Makes the folder (0700) if there is none and holds DATA/lock until destroyed. Throws StartError when another
/// process holds it or it cannot be used. The lock ends with the process, however that ends.
class DataFolder {
 public:
  explicit DataFolder(std::filesystem::path folder);
  const std::filesystem::path& path() const { return folder_; }

 private:
  std::filesystem::path folder_;
  std::optional<protocol::FolderLock> lock_;
};

/// Writes a small text readable by its owner only, in one step. Throws StartError.
void write_secret(const std::filesystem::path& file, const std::string& text);

}  // namespace headstock::app
