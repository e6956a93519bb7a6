#include "server/backup/archive.hpp"

#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <vector>

#include "db/database.hpp"
#include "db/hash.hpp"
#include "db/refusal.hpp"

namespace headstock::backup {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kPiece = 1u << 18;

[[noreturn]] void fail(const fs::path& file, const std::string& what, int error) {
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  throw db::Error(full ? db::Problem::disk_full : db::Problem::unreadable, file.string() + ": " + what);
}

/// Only plain names below the archive's own root.
bool safe_name(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.size() > 1000) return false;
  for (const auto& part : fs::path(name))
    if (part == ".." || part == ".") return false;
  return true;
}

struct Read {
  void operator()(archive* handle) const { archive_read_free(handle); }
};
using Reading = std::unique_ptr<archive, Read>;

/// A backup that was cut off is still known by how it begins: the mark of Zstandard (RFC 8878, 3.1.1).
bool is_packed(const fs::path& file) {
  std::array<char, 4> head{};
  std::ifstream(file, std::ios::binary).read(head.data(), head.size());
  return head == std::array<char, 4>{'\x28', '\xB5', '\x2F', '\xFD'};
}

Reading open(const fs::path& file) {
  Reading reading(archive_read_new());
  archive_read_support_filter_zstd(reading.get());
  archive_read_support_format_tar(reading.get());
  if (archive_read_open_filename(reading.get(), file.c_str(), kPiece) != ARCHIVE_OK)
    throw db::Refusal(!fs::exists(file)    ? "not_found"
                      : is_packed(file) ? "damaged_backup"
                                        : "not_a_backup",
                      file.filename().string());
  return reading;
}

class ArchiveEntry final : public Entry {
 public:
  ArchiveEntry(archive* handle, archive_entry* entry)
      : handle_(handle), name_(archive_entry_pathname(entry) ? archive_entry_pathname(entry) : ""),
        bytes_(static_cast<std::uint64_t>(archive_entry_size(entry))) {
    if (!safe_name(name_)) throw db::Refusal("damaged_backup", name_);
  }
  const std::string& name() const override { return name_; }
  std::uint64_t bytes() const override { return bytes_; }
  std::size_t read(char* into, std::size_t at_most) override {
    const la_ssize_t got = archive_read_data(handle_, into, at_most);
    if (got < 0) throw db::Refusal("damaged_backup", name_);
    return static_cast<std::size_t>(got);
  }

 private:
  archive* handle_;
  std::string name_;
  std::uint64_t bytes_;
};

void each(const fs::path& file, const std::function<void(Entry&)>& visit) {
  const Reading reading = open(file);
  bool first = true;
  for (;;) {
    archive_entry* entry = nullptr;
    const int result = archive_read_next_header(reading.get(), &entry);
    if (result == ARCHIVE_EOF) return;
    if (result != ARCHIVE_OK)
      throw db::Refusal(first && !is_packed(file) ? "not_a_backup" : "damaged_backup", file.filename().string());
    first = false;
    ArchiveEntry found(reading.get(), entry);
    visit(found);
  }
}

}  // namespace

struct ArchiveWriter::Impl {
  explicit Impl(const fs::path& target) : file(target), part(target.string() + ".part") {
    handle = archive_write_new();
    archive_write_add_filter_zstd(handle);
    archive_write_set_format_pax_restricted(handle);
    // The file names programs and holds passwords' hashes and keys: for its owner alone.
    descriptor = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (descriptor < 0) fail(part, std::strerror(errno), errno);
    check(archive_write_open_fd(handle, descriptor));
  }
  ~Impl() {
    archive_write_free(handle);
    if (descriptor >= 0) ::close(descriptor);
    std::error_code ignored;
    fs::remove(part, ignored);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void check(int result) {
    if (result != ARCHIVE_OK) fail(part, archive_error_string(handle) ? archive_error_string(handle) : "cannot write", archive_errno(handle));
  }
  void write(std::string_view bytes) {
    while (!bytes.empty()) {
      const la_ssize_t written = archive_write_data(handle, bytes.data(), bytes.size());
      if (written <= 0) check(ARCHIVE_FATAL);
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  void begin(const std::string& name, std::uint64_t bytes) {
    archive_entry* const entry = archive_entry_new();
    archive_entry_set_pathname(entry, name.c_str());
    archive_entry_set_size(entry, static_cast<la_int64_t>(bytes));
    archive_entry_set_filetype(entry, AE_IFREG);
    archive_entry_set_perm(entry, 0600);
    const int result = archive_write_header(handle, entry);
    archive_entry_free(entry);
    check(result);
  }
  void note(const std::string& name, std::uint64_t bytes, std::string sha256) {
    entries.push_back({{"name", name}, {"bytes", bytes}, {"sha256", std::move(sha256)}});
  }

  fs::path file, part;
  archive* handle = nullptr;
  int descriptor = -1;
  json entries = json::array();
};

ArchiveWriter::ArchiveWriter(const fs::path& file) : impl_(std::make_unique<Impl>(file)) {}
ArchiveWriter::~ArchiveWriter() = default;

void ArchiveWriter::add(const std::string& name, std::string_view bytes) {
  impl_->begin(name, bytes.size());
  impl_->write(bytes);
  impl_->note(name, bytes.size(), db::sha256_hex(bytes));
}

void ArchiveWriter::add_file(const std::string& name, const fs::path& file, const std::string& sha256) {
  std::error_code error;
  const std::uint64_t bytes = fs::file_size(file, error);
  std::ifstream in(file, std::ios::binary);
  if (error || !in) throw db::Error(db::Problem::corrupt, file.string() + ": cannot be read for the backup");
  impl_->begin(name, bytes);
  db::Sha256 hash;
  std::vector<char> piece(kPiece);
  std::uint64_t done = 0;
  while (done < bytes && in.read(piece.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(kPiece, bytes - done))).gcount() > 0) {
    const std::string_view got(piece.data(), static_cast<std::size_t>(in.gcount()));
    hash.add(got);
    impl_->write(got);
    done += got.size();
  }
  std::string found = hash.hex();
  if (done != bytes || (!sha256.empty() && found != sha256))
    throw db::Error(db::Problem::corrupt, file.string() + ": differs from what was stored; the backup was not made");
  impl_->note(name, bytes, std::move(found));
}

ArchiveWriter::Finished ArchiveWriter::finish(json about) {
  about["format"] = kFormat;
  about["entries"] = impl_->entries;
  const std::string manifest = about.dump(1);
  impl_->begin(kManifest, manifest.size());
  impl_->write(manifest);
  impl_->check(archive_write_close(impl_->handle));
  if (::fsync(impl_->descriptor) != 0) fail(impl_->part, std::strerror(errno), errno);
  ::close(impl_->descriptor);
  impl_->descriptor = -1;
  db::Sha256 hash;
  Finished finished;
  std::ifstream in(impl_->part, std::ios::binary);
  std::vector<char> piece(kPiece);
  while (in.read(piece.data(), static_cast<std::streamsize>(piece.size())), in.gcount() > 0) {
    hash.add({piece.data(), static_cast<std::size_t>(in.gcount())});
    finished.bytes += static_cast<std::uint64_t>(in.gcount());
  }
  finished.sha256 = hash.hex();
  std::error_code error;
  fs::rename(impl_->part, impl_->file, error);
  if (error) fail(impl_->file, error.message(), error.value());
  const int folder = ::open(impl_->file.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    ::fsync(folder);
    ::close(folder);
  }
  return finished;
}

std::string Entry::all(std::uint64_t limit) {
  if (bytes() > limit) throw db::Refusal("damaged_backup", name());
  std::string text(static_cast<std::size_t>(bytes()), '\0');
  std::size_t done = 0;
  while (done < text.size()) {
    const std::size_t got = read(text.data() + done, text.size() - done);
    if (got == 0) throw db::Refusal("damaged_backup", name());
    done += got;
  }
  return text;
}

json verify(const fs::path& file) {
  std::map<std::string, std::pair<std::uint64_t, std::string>> found;
  json manifest;
  std::vector<char> piece(kPiece);
  each(file, [&](Entry& entry) {
    if (entry.name() == kManifest) {
      manifest = json::parse(entry.all(), nullptr, false);
      return;
    }
    if (!manifest.is_null()) throw db::Refusal("damaged_backup", entry.name());  // something behind the end
    db::Sha256 hash;
    std::uint64_t bytes = 0;
    while (const std::size_t got = entry.read(piece.data(), piece.size())) {
      hash.add({piece.data(), got});
      bytes += got;
    }
    found[entry.name()] = {bytes, hash.hex()};
  });
  if (!manifest.is_object() || !manifest.contains("entries")) throw db::Refusal("damaged_backup", kManifest);
  if (manifest.value("format", 0) > kFormat) throw db::Refusal("newer_backup", file.filename().string());
  for (const json& entry : manifest.at("entries")) {
    const std::string name = entry.value("name", "");
    const auto one = found.find(name);
    if (one == found.end() || one->second.first != entry.value("bytes", std::uint64_t{0}) ||
        one->second.second != entry.value("sha256", ""))
      throw db::Refusal("damaged_backup", name);
    found.erase(one);
  }
  if (!found.empty()) throw db::Refusal("damaged_backup", found.begin()->first);
  return manifest;
}

void each_entry(const fs::path& file, const std::function<void(Entry&)>& visit) {
  each(file, [&](Entry& entry) {
    if (entry.name() != kManifest) visit(entry);
  });
}

}  // namespace headstock::backup
