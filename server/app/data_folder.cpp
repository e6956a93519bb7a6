#include "server/app/data_folder.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/app/shop.hpp"

namespace headstock::app {

namespace fs = std::filesystem;

DataFolder::DataFolder(fs::path folder) : folder_(std::move(folder)) {
  try {
    lock_.emplace(folder_, "headstock-server");
  } catch (const protocol::FolderUnusable& unusable) {
    throw StartError(unusable.in_use ? StartError::data_in_use : StartError::other, unusable.what());
  }
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
