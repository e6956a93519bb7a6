#include "link/program_memory.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>

#include "link/program_file.hpp"
#include "link/program_name.hpp"
#include "protocol/wire/digest.hpp"

namespace headstock::link {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr std::size_t kMaxName = 64;
constexpr std::uint64_t kMaxProgram = 1ull << 40;
/// A put that was given up stays this long for a resume.
constexpr auto kKeepIncoming = std::chrono::hours(24 * 7);

std::int64_t now_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

struct Resident : ResidentProgram {
  std::int64_t modified_ns = 0;                 ///< of the file when it was hashed
  std::optional<std::uint32_t> number_at_head;  ///< O word at the head of the text
};

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

std::optional<std::uint32_t> read_number_at_head(const fs::path& path) {
  const File file = open_for_reading(path);
  if (!file) return std::nullopt;
  std::array<char, 1024> head{};
  const ssize_t got = ::read(file.get(), head.data(), head.size());
  return got > 0 ? number_in_text({head.data(), static_cast<std::size_t>(got)}) : std::nullopt;
}

}  // namespace

struct ProgramMemory::Impl {
  fs::path folder;
  std::uint64_t limit = 0;
  mutable std::mutex mutex;
  std::map<std::string, Resident> programs;
  std::set<std::string> incoming;  ///< hashes of puts that are going on
  std::function<bool(const std::string&)> running;
  std::function<void()> notify;
  std::function<std::unique_ptr<program::Source>(std::uint32_t)> external;

  fs::path index_file() const { return folder / ".index.json"; }
  fs::path incoming_folder() const { return folder / ".incoming"; }

  std::uint64_t used() const {
    std::uint64_t bytes = 0;
    for (const auto& [name, program] : programs) bytes += program.bytes;
    return bytes;
  }
  bool fits(const std::string& name, std::uint64_t bytes) const {
    const auto old = programs.find(name);
    const std::uint64_t others = used() - (old == programs.end() ? 0 : old->second.bytes);
    return bytes <= limit && others <= limit - bytes;
  }
  bool is_running(const std::string& name) {
    std::function<bool(const std::string&)> ask;
    {
      const std::scoped_lock lock(mutex);
      ask = running;
    }
    return ask && ask(name);
  }
  void changed() {
    std::function<void()> tell;
    {
      const std::scoped_lock lock(mutex);
      tell = notify;
    }
    if (tell) tell();
  }
  /// The index only saves hashing at start; losing it loses nothing, so an error here is no error of the put.
  void write_index() const {
    json index = json::object();
    for (const auto& [name, p] : programs)
      index[name] = {
          {"sha256", p.sha256}, {"bytes", p.bytes}, {"since_ms", p.since_ms}, {"modified_ns", p.modified_ns}};
    (void)replace_file(index_file(), index.dump());
  }
  void load();
  /// Takes a file that now stands in the folder into the table.
  void adopt(const std::string& name, const std::string& sha256, std::int64_t since_ms);
};

void ProgramMemory::Impl::adopt(const std::string& name, const std::string& sha256, std::int64_t since_ms) {
  const fs::path path = folder / name;
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return;
  Resident program;
  program.name = name;
  program.sha256 = sha256;
  program.bytes = static_cast<std::uint64_t>(status.st_size);
  program.since_ms = since_ms;
  program.modified_ns = status.st_mtim.tv_sec * 1'000'000'000 + status.st_mtim.tv_nsec;
  program.number_at_head = read_number_at_head(path);
  programs[name] = std::move(program);
}

void ProgramMemory::Impl::load() {
  json index = json::object();
  if (const File file = open_for_reading(index_file())) {
    std::string text(static_cast<std::size_t>(fs::file_size(index_file())), '\0');
    const ssize_t got = ::read(file.get(), text.data(), text.size());
    text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    index = json::parse(text, nullptr, false);
    if (!index.is_object()) index = json::object();
  }
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || entry.is_symlink() || !valid_name(name)) continue;
    adopt(name, "", now_ms());
    Resident& program = programs[name];
    const json known = index.value(name, json::object());
    const bool same = known.is_object() && known.value("bytes", std::uint64_t{0}) == program.bytes &&
                      known.value("modified_ns", std::int64_t{0}) == program.modified_ns;
    if (same && wire::is_sha256_hex(known.value("sha256", ""))) {
      program.sha256 = known.value("sha256", "");
      program.since_ms = known.value("since_ms", program.since_ms);
    } else if (const auto hash = hash_file(entry.path())) {
      program.sha256 = *hash;
    } else {
      programs.erase(name);
    }
  }
  for (const auto& entry : fs::directory_iterator(incoming_folder()))
    if (fs::file_time_type::clock::now() - entry.last_write_time() > kKeepIncoming) fs::remove(entry.path());
  write_index();
}

namespace {

/// The same content is resident already.
class AlreadyResident final : public IncomingProgram {
 public:
  AlreadyResident(std::uint64_t bytes, std::string sha256) : bytes_(bytes), sha256_(std::move(sha256)) {}
  std::uint64_t offset() const override { return bytes_; }
  std::string prefix_sha256() const override { return sha256_; }
  MemoryResult append(std::string_view bytes) override { return {bytes.empty() ? "" : "bad_hash"}; }
  MemoryResult finish() override { return {}; }

 private:
  std::uint64_t bytes_;
  std::string sha256_;
};

}  // namespace

/// Bytes into `.incoming/<sha256>`, kept when the put is cut.
class IncomingFile final : public IncomingProgram {
 public:
  IncomingFile(std::shared_ptr<ProgramMemory::Impl> memory, std::string name, std::uint64_t bytes,
               std::string sha256)
      : memory_(std::move(memory)), name_(std::move(name)), sha256_(std::move(sha256)), bytes_(bytes) {}
  ~IncomingFile() override {
    const std::scoped_lock lock(memory_->mutex);
    memory_->incoming.erase(sha256_);
  }

  MemoryResult open() {
    path_ = memory_->incoming_folder() / sha256_;
    file_ = File(::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
    if (!file_) return {"disk_error"};
    std::vector<char> buffer(256u << 10);
    for (;;) {
      const ssize_t got = ::read(file_.get(), buffer.data(), buffer.size());
      if (got <= 0) break;
      digest_.update({buffer.data(), static_cast<std::size_t>(got)});
      offset_ += static_cast<std::uint64_t>(got);
    }
    if (offset_ > bytes_) return restart();
    return {};
  }

  std::uint64_t offset() const override { return offset_; }
  std::string prefix_sha256() const override { return digest_.hex(); }

  MemoryResult append(std::string_view bytes) override {
    if (bytes.size() > bytes_ - offset_) return {"bad_hash"};
    if (auto result = write_all(file_, bytes); !result.ok()) {
      // A part of the block may stand in the file: the file and the running hash must agree for a resume.
      if (::ftruncate(file_.get(), static_cast<off_t>(offset_)) == 0)
        ::lseek(file_.get(), static_cast<off_t>(offset_), SEEK_SET);
      return result;
    }
    digest_.update(bytes);
    offset_ += bytes.size();
    return {};
  }

  MemoryResult finish() override {
    if (offset_ != bytes_ || digest_.hex() != sha256_) {
      ::unlink(path_.c_str());
      return {"bad_hash"};
    }
    if (memory_->is_running(name_)) return {"running"};
    {
      const std::scoped_lock lock(memory_->mutex);
      if (!memory_->fits(name_, bytes_)) {
        ::unlink(path_.c_str());
        return {"memory_full"};
      }
      if (auto result = rename_durably(file_, path_, memory_->folder / name_); !result.ok()) return result;
      memory_->adopt(name_, sha256_, now_ms());
      memory_->write_index();
    }
    memory_->changed();
    return {};
  }

 private:
  MemoryResult restart() {
    digest_.reset();
    offset_ = 0;
    return {::ftruncate(file_.get(), 0) == 0 && ::lseek(file_.get(), 0, SEEK_SET) == 0 ? "" : "disk_error"};
  }

  std::shared_ptr<ProgramMemory::Impl> memory_;
  std::string name_, sha256_;
  std::uint64_t bytes_ = 0, offset_ = 0;
  fs::path path_;
  File file_;
  wire::Sha256 digest_;
};

ProgramMemory::ProgramMemory(fs::path folder, std::uint64_t limit_bytes) : impl_(std::make_shared<Impl>()) {
  impl_->folder = std::move(folder);
  impl_->limit = limit_bytes;
  std::error_code error;
  fs::create_directories(impl_->incoming_folder(), error);
  if (error || ::access(impl_->folder.c_str(), R_OK | W_OK | X_OK) != 0)
    throw std::runtime_error(impl_->folder.string() + ": the folder of programs cannot be used: " +
                             (error ? error.message() : "no permission to write"));
  impl_->load();
}

ProgramMemory::~ProgramMemory() = default;

bool ProgramMemory::valid_name(std::string_view name) {
  if (name.empty() || name.size() > kMaxName || name.front() == '.' || name.front() == ' ' ||
      name.back() == ' ')
    return false;
  return std::ranges::all_of(name, [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x80 || std::isalnum(byte) ||
           std::string_view("_-+.() ").find(c) != std::string_view::npos;
  });
}

void ProgramMemory::in_use(std::function<bool(const std::string&)> running) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->running = std::move(running);
}

void ProgramMemory::on_change(std::function<void()> notify) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->notify = std::move(notify);
}

std::vector<ResidentProgram> ProgramMemory::census() const {
  const std::scoped_lock lock(impl_->mutex);
  std::vector<ResidentProgram> list;
  list.reserve(impl_->programs.size());
  for (const auto& [name, program] : impl_->programs) list.push_back(program);
  return list;
}

std::optional<ResidentProgram> ProgramMemory::find(std::string_view name) const {
  const std::scoped_lock lock(impl_->mutex);
  const auto found = impl_->programs.find(std::string(name));
  return found == impl_->programs.end() ? std::nullopt : std::optional<ResidentProgram>(found->second);
}

std::uint64_t ProgramMemory::used_bytes() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->used();
}

std::uint64_t ProgramMemory::limit_bytes() const {
  return impl_->limit;
}

std::string ProgramMemory::census_hash() const {
  wire::Sha256 digest;
  for (const auto& program : census()) digest.update(program.name + '\n' + program.sha256 + '\n');
  return digest.hex();
}

std::unique_ptr<IncomingProgram> ProgramMemory::begin_put(const std::string& name, std::uint64_t bytes,
                                                          const std::string& sha256, MemoryResult& result) {
  result = {};
  if (!valid_name(name))
    result.reason = "bad_name";
  else if (!wire::is_sha256_hex(sha256) || bytes > kMaxProgram)
    result.reason = "bad_hash";
  if (!result.ok()) return nullptr;
  if (const auto old = find(name); old && old->sha256 == sha256 && old->bytes == bytes)
    return std::make_unique<AlreadyResident>(bytes, sha256);
  if (impl_->is_running(name)) {
    result.reason = "running";
    return nullptr;
  }
  {
    const std::scoped_lock lock(impl_->mutex);
    if (!impl_->fits(name, bytes))
      result.reason = "memory_full";
    else if (!impl_->incoming.insert(sha256).second)
      result.reason = "busy";
    if (!result.ok()) return nullptr;
  }
  auto incoming = std::make_unique<IncomingFile>(impl_, name, bytes, sha256);
  result = incoming->open();
  return result.ok() ? std::move(incoming) : nullptr;
}

MemoryResult ProgramMemory::put(const std::string& name, std::string_view text) {
  MemoryResult result;
  const auto incoming = begin_put(name, text.size(), wire::sha256_hex(text), result);
  if (!incoming) return result;
  result = incoming->append(text.substr(std::min<std::size_t>(text.size(), incoming->offset())));
  return result.ok() ? incoming->finish() : result;
}

MemoryResult ProgramMemory::remove(const std::string& name) {
  if (!find(name)) return {"not_found"};
  if (impl_->is_running(name)) return {"running"};
  {
    const std::scoped_lock lock(impl_->mutex);
    if (::unlink((impl_->folder / name).c_str()) != 0 && errno != ENOENT) return {"disk_error"};
    impl_->programs.erase(name);
    impl_->write_index();
  }
  impl_->changed();
  return {};
}

std::unique_ptr<program::Source> ProgramMemory::open_number(std::uint32_t number) {
  const std::scoped_lock lock(impl_->mutex);
  const Resident* found = nullptr;
  for (const auto& [name, program] : impl_->programs) {
    if (number_in_name(name) == number) {
      found = &program;
      break;
    }
    if (!found && !number_in_name(name) && program.number_at_head == number) found = &program;
  }
  if (!found) return nullptr;
  File file = open_for_reading(impl_->folder / found->name);
  return file ? source_from_file(std::move(file)) : nullptr;
}

void ProgramMemory::on_external(std::function<std::unique_ptr<program::Source>(std::uint32_t)> open) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->external = std::move(open);
}

std::unique_ptr<program::Source> ProgramMemory::open_external(std::uint32_t number) {
  std::function<std::unique_ptr<program::Source>(std::uint32_t)> ask;
  {
    const std::scoped_lock lock(impl_->mutex);
    ask = impl_->external;
  }
  return ask ? ask(number) : open_number(number);
}

std::unique_ptr<program::Source> ProgramMemory::open_name(std::string_view name) {
  const std::scoped_lock lock(impl_->mutex);
  const std::string wanted = lower(name);
  auto found = impl_->programs.find(std::string(name));
  if (found == impl_->programs.end())
    found = std::ranges::find_if(impl_->programs, [&](const auto& entry) {
      const std::string candidate = lower(entry.first);
      return candidate == wanted || candidate == wanted + ".nc";
    });
  if (found == impl_->programs.end()) return nullptr;
  File file = open_for_reading(impl_->folder / found->first);
  return file ? source_from_file(std::move(file)) : nullptr;
}

}  // namespace headstock::link
