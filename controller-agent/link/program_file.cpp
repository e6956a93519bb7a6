#include "link/program_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <vector>

#include "protocol/wire/digest.hpp"

namespace headstock::link {
namespace {

MemoryResult disk_result() {
  return {errno == ENOSPC || errno == EDQUOT || errno == EFBIG ? "disk_full" : "disk_error"};
}

class FileSource final : public program::Source {
 public:
  explicit FileSource(File file) : file_(std::move(file)) {}

  program::ReadResult read(std::span<char> buffer) override {
    for (;;) {
      const ssize_t got = ::pread(file_.get(), buffer.data(), buffer.size(), static_cast<off_t>(offset_));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) return {program::ReadStatus::failed, 0};
      if (got == 0) return {program::ReadStatus::end, 0};
      offset_ += static_cast<std::uint64_t>(got);
      return {program::ReadStatus::data, static_cast<std::size_t>(got)};
    }
  }
  bool seek(std::uint64_t byte_offset) override {
    offset_ = byte_offset;
    return true;
  }

 private:
  File file_;
  std::uint64_t offset_ = 0;
};

}  // namespace

File& File::operator=(File&& other) noexcept {
  if (this != &other) {
    close();
    descriptor_ = other.release();
  }
  return *this;
}

void File::close() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

File open_for_reading(const std::filesystem::path& path) {
  return File(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
}

MemoryResult write_all(const File& file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return disk_result();
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

MemoryResult rename_durably(const File& file, const std::filesystem::path& from,
                            const std::filesystem::path& to) {
  if (::fsync(file.get()) != 0) return disk_result();
  if (::rename(from.c_str(), to.c_str()) != 0) return disk_result();
  const File folder(::open(to.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder || ::fsync(folder.get()) != 0) return disk_result();
  return {};
}

MemoryResult replace_file(const std::filesystem::path& path, std::string_view text) {
  std::filesystem::path temporary = path;
  temporary += ".new";
  const File file(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600));
  if (!file) return disk_result();
  if (auto result = write_all(file, text); !result.ok()) {
    ::unlink(temporary.c_str());
    return result;
  }
  return rename_durably(file, temporary, path);
}

std::optional<std::string> hash_file(const std::filesystem::path& path) {
  const File file = open_for_reading(path);
  if (!file) return std::nullopt;
  wire::Sha256 digest;
  std::vector<char> buffer(256u << 10);
  for (;;) {
    const ssize_t got = ::read(file.get(), buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return std::nullopt;
    if (got == 0) return digest.hex();
    digest.update({buffer.data(), static_cast<std::size_t>(got)});
  }
}

std::unique_ptr<program::Source> source_from_file(File file) {
  return std::make_unique<FileSource>(std::move(file));
}

}  // namespace headstock::link
