// One agent's folder: everything it keeps, and the lock that lets only one agent use it.
#pragma once

#include <filesystem>

#include "protocol/process/folder_lock.hpp"

namespace headstock::agent {

/// Where things are. The folder may be copied as a whole to a replacement computer.
class DataFolder {
 public:
  /// Makes the folder when missing and locks it until destruction. Throws std::runtime_error with a sentence for a
  /// person when it cannot be used or another agent uses it.
  explicit DataFolder(std::filesystem::path folder);

  std::filesystem::path spool() const { return folder_ / "spool.db"; }
  std::filesystem::path programs() const { return folder_ / "programs"; }
  std::filesystem::path pki() const { return folder_ / "identity"; }
  std::filesystem::path machine_file() const { return folder_ / "machine.toml"; }
  static std::filesystem::path panel_socket(const std::filesystem::path& folder) { return folder / "panel.sock"; }
  std::filesystem::path panel_socket() const { return panel_socket(folder_); }

 private:
  std::filesystem::path folder_;
  protocol::FolderLock lock_;
};

}  // namespace headstock::agent
