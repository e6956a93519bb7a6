// A folder that belongs to one process at a time.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace headstock::protocol {

/// Why a folder cannot be had; the message is for the person who started the program.
class FolderUnusable : public std::runtime_error {
 public:
  FolderUnusable(bool held, const std::string& text) : std::runtime_error(text), in_use(held) {}
  const bool in_use;  ///< another process holds it
};

/// Holds FOLDER/lock until destroyed; it ends with the process, however that ends.
class FolderLock {
 public:
  /// Makes the folder (0700) if there is none. @param owner what another holder is called: "headstock-server".
  /// Throws FolderUnusable.
  FolderLock(const std::filesystem::path& folder, const std::string& owner);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_ = -1;
};

}  // namespace headstock::protocol
