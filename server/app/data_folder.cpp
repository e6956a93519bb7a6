#include "server/app/data_folder.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/app/shop.hpp"

namespace headstock::app {

namespace fs = std::filesystem;

DataFolder::DataFolder(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  const bool made = fs::create_directories(folder_, error);
  if (error) throw StartError(StartError::other, "cannot make the data folder " + folder_.string() + ": " + error.message());
  if (made) fs::permissions(folder_, fs::perms::owner_all, error);
  const auto file = folder_ / "lock";
  lock_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock_ < 0)
    throw StartError(StartError::other, "cannot use the data folder " + folder_.string() + ": " + std::strerror(errno));
  if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    ::close(lock_);
    throw StartError(StartError::data_in_use,
                     "data folder in use: another headstock-server runs with " + folder_.string() + "; stop it or choose another folder");
  }
}

DataFolder::~DataFolder() {
  if (lock_ >= 0) ::close(lock_);
}

void write_secret(const fs::path& file, const std::string& text) {
  const fs::path temporary = file.string() + ".new";
  const int out = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const bool written = out >= 0 && ::fchmod(out, 0600) == 0 &&
                       ::write(out, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(out) == 0;
  const int error = errno;
  if (out >= 0) ::close(out);
  if (!written || std::rename(temporary.c_str(), file.c_str()) != 0)
    throw StartError(StartError::other, "cannot write " + file.string() + ": " + std::strerror(written ? errno : error));
}

}  // namespace headstock::app
