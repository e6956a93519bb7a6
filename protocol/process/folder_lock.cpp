#include "protocol/process/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace headstock::protocol {

namespace fs = std::filesystem;

FolderLock::FolderLock(const fs::path& folder, const std::string& owner) {
  std::error_code error;
  const bool made = fs::create_directories(folder, error);
  if (error) throw FolderUnusable(false, "cannot make the data folder " + folder.string() + ": " + error.message());
  if (made) fs::permissions(folder, fs::perms::owner_all, error);
  file_ = ::open((folder / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file_ < 0)
    throw FolderUnusable(false, "cannot use the data folder " + folder.string() + ": " + std::strerror(errno));
  if (::flock(file_, LOCK_EX | LOCK_NB) != 0) {
    ::close(file_);
    throw FolderUnusable(true, "data folder in use: another " + owner + " runs with " + folder.string() +
                                   "; stop it or choose another folder");
  }
}

FolderLock::~FolderLock() {
  ::close(file_);
}

}  // namespace headstock::protocol
