// The programs resident in one machine: a folder with a limit in bytes, as the control's own program memory
// has.
//
// A program appears whole or not at all: it is written beside, synced, hashed and then renamed over the old
// one. What is being read keeps reading the old text. A put that was cut goes on where it stopped, after a
// restart too.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "link/memory_result.hpp"
#include "program/source.hpp"

namespace headstock::link {

/// One line of the census.
struct ResidentProgram {
  std::string name;  ///< "O1001", "flange.nc"
  std::string sha256;
  std::uint64_t bytes = 0;
  std::int64_t since_ms = 0;  ///< Unix time it became resident
};

/// A program on its way into the memory.
class IncomingProgram {
 public:
  virtual ~IncomingProgram() = default;
  /// Bytes already here (from before a cut): the sender goes on from there.
  virtual std::uint64_t offset() const = 0;
  /// Lower-case hex SHA-256 of these bytes.
  virtual std::string prefix_sha256() const = 0;
  virtual MemoryResult append(std::string_view bytes) = 0;
  /// Verifies length and hash and replaces the resident program in one step. On "bad_hash" the bytes are
  /// thrown away; on "running" they are kept for a later attempt.
  virtual MemoryResult finish() = 0;
};

/// Any thread.
class ProgramMemory final : public program::Programs {
 public:
  /// Opens the folder, makes it when it is missing, and hashes what was changed behind our back.
  /// @param limit_bytes all resident programs together. Throws std::runtime_error when the folder cannot be
  /// used.
  ProgramMemory(std::filesystem::path folder, std::uint64_t limit_bytes);
  ~ProgramMemory() override;

  /// 1…64 of letters, digits, `_ - + . ( )`, space or non-ASCII UTF-8; no leading dot or space, no path, no
  /// device.
  static bool valid_name(std::string_view name);

  /// Tells which program may not be replaced or deleted now (it is running). Called on the caller's thread.
  void in_use(std::function<bool(const std::string& name)> running);

  std::vector<ResidentProgram> census() const;
  std::optional<ResidentProgram> find(std::string_view name) const;
  std::uint64_t used_bytes() const;
  std::uint64_t limit_bytes() const;
  /// SHA-256 over the census; equal at both ends means nothing has to be sent.
  std::string census_hash() const;

  /// Starts or goes on with a put. The same content under the same name is finished at once (offset() ==
  /// bytes).
  /// @param result why not, when nullptr is returned.
  std::unique_ptr<IncomingProgram> begin_put(const std::string& name, std::uint64_t bytes,
                                             const std::string& sha256, MemoryResult& result);
  /// The whole text at once (local panel, tests).
  MemoryResult put(const std::string& name, std::string_view text);
  MemoryResult remove(const std::string& name);

  /// O number: the name `O1001` (zeros and ending do not matter), else the first O word at the head of a
  /// program.
  std::unique_ptr<program::Source> open_number(std::uint32_t number) override;
  /// M198: from the server when there is one (see on_external), else as open_number.
  std::unique_ptr<program::Source> open_external(std::uint32_t number) override;
  /// Exact name, else without regard to case and to a missing ending `.nc`.
  std::unique_ptr<program::Source> open_name(std::string_view name) override;

  /// Where M198 gets its programs, called on the interpreter's thread; it may answer with nullptr. An empty function
  /// takes it off.
  void on_external(std::function<std::unique_ptr<program::Source>(std::uint32_t number)> open);

  /// Called after the resident programs changed, on the changing thread. An empty function takes it off.
  void on_change(std::function<void()> notify);

 private:
  friend class IncomingFile;
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace headstock::link
