#include "db/blobs.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "db/database.hpp"

namespace headstock::db {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const char* what, int error) {
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  throw Error(full ? Problem::disk_full : Problem::unreadable,
              path.string() + ": " + what + ": " + std::strerror(error));
}

/// A rename is on the disk only when its folder is.
void sync_folder(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) fail(folder, "cannot open", errno);
  const int result = ::fsync(file);
  const int error = errno;
  ::close(file);
  if (result != 0) fail(folder, "cannot sync", error);
}

}  // namespace

Blobs::Blobs(fs::path data_folder) : folder_(std::move(data_folder) / "blobs") {
  std::error_code error;
  fs::create_directories(folder_ / "incoming", error);
  if (error)
    throw Error(Problem::unreadable, folder_.string() + ": cannot make the folder (" + error.message() + ")");
  std::vector<fs::path> left_over;
  for (const auto& entry : fs::directory_iterator(folder_ / "incoming")) left_over.push_back(entry.path());
  for (const auto& path : left_over) fs::remove(path, error);
}

fs::path Blobs::path(const std::string& sha256) const {
  if (sha256.size() != 64 || sha256.find_first_not_of("0123456789abcdef") != std::string::npos)
    throw Error(Problem::internal, "not a SHA-256: " + sha256);
  return folder_ / sha256.substr(0, 2) / sha256.substr(2);
}

Blobs::Writer Blobs::begin() const {
  fs::path temporary = folder_ / "incoming" / random_hex(16);
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640);
  if (file < 0) fail(temporary, "cannot create", errno);
  return Writer(*this, std::move(temporary), file);
}

Blobs::Writer::Writer(const Blobs& home, fs::path temporary, int file)
    : home_(&home), temporary_(std::move(temporary)), file_(file) {}

Blobs::Writer::Writer(Writer&& other) noexcept
    : home_(other.home_),
      temporary_(std::move(other.temporary_)),
      file_(std::exchange(other.file_, -1)),
      hash_(std::move(other.hash_)),
      bytes_(other.bytes_) {}

Blobs::Writer::~Writer() {
  if (file_ < 0) return;
  ::close(file_);
  ::unlink(temporary_.c_str());
}

void Blobs::Writer::append(std::string_view bytes) {
  hash_.add(bytes);
  bytes_ += bytes.size();
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(temporary_, "cannot write", errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

std::string Blobs::Writer::finish() {
  const std::string sha256 = hash_.hex();
  const fs::path target = home_->path(sha256);
  std::error_code error;
  const std::uintmax_t present = fs::file_size(target, error);
  if (!error && present == bytes_) {
    ::close(std::exchange(file_, -1));
    ::unlink(temporary_.c_str());
    return sha256;
  }
  if (::fchmod(file_, 0440) != 0 || ::fsync(file_) != 0) fail(temporary_, "cannot sync", errno);
  if (fs::create_directory(target.parent_path(), error)) sync_folder(home_->folder_);
  if (error) fail(target.parent_path(), "cannot make the folder", error.value());
  if (::rename(temporary_.c_str(), target.c_str()) != 0) fail(target, "cannot rename", errno);
  ::close(std::exchange(file_, -1));
  sync_folder(target.parent_path());
  return sha256;
}

std::shared_ptr<Blobs::Reader> Blobs::open(const std::string& sha256) const {
  const fs::path file_path = path(sha256);
  const int file = ::open(file_path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0)
    throw Error(Problem::corrupt,
                file_path.string() + ": a stored program is missing: " + std::strerror(errno));
  struct stat facts {};
  if (::fstat(file, &facts) != 0) {
    const int error = errno;
    ::close(file);
    fail(file_path, "cannot read", error);
  }
  return std::shared_ptr<Reader>(new Reader(file, static_cast<std::uint64_t>(facts.st_size)));
}

Blobs::Reader::~Reader() {
  ::close(file_);
}

std::size_t Blobs::Reader::read(std::uint64_t offset, char* into, std::size_t at_most) const {
  std::size_t done = 0;
  while (done < at_most && offset + done < size_) {
    const ssize_t got = ::pread(file_, into + done, at_most - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("stored program", "cannot read", errno);
    if (got == 0) throw Error(Problem::corrupt, "a stored program has become shorter than it was");
    done += static_cast<std::size_t>(got);
  }
  return done;
}

std::shared_ptr<const Blobs::Mapped> Blobs::map(const std::string& sha256) const {
  const auto reader = open(sha256);
  const auto size = static_cast<std::size_t>(reader->size());
  if (size == 0) return std::shared_ptr<const Mapped>(new Mapped("", 0));
  void* const bytes = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, reader->file_, 0);
  if (bytes == MAP_FAILED) fail(path(sha256), "cannot map", errno);
  return std::shared_ptr<const Mapped>(new Mapped(static_cast<const char*>(bytes), size));
}

Blobs::Mapped::~Mapped() {
  if (size_ > 0) ::munmap(const_cast<char*>(bytes_), size_);
}

bool Blobs::verify(const std::string& sha256) const {
  std::error_code error;
  if (!fs::exists(path(sha256), error)) return false;
  const auto reader = open(sha256);
  Sha256 hash;
  std::vector<char> buffer(1u << 18);
  for (std::uint64_t at = 0; at < reader->size();) {
    const std::size_t got = reader->read(at, buffer.data(), buffer.size());
    hash.add({buffer.data(), got});
    at += got;
  }
  return hash.hex() == sha256;
}

}  // namespace headstock::db
