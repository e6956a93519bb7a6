// What must not be lost, on disk before anything depends on it: the events on their way to the server, and
// the values that must survive a power cut together with them (part count, selected program, offsets).
//
// SQLite in WAL mode with synchronous=FULL: `commit` returns after the data are on the disk. One transaction
// holds the events and the retained values that belong to them, so that a part is never counted without its
// event or twice. A process that dies at any instant (kill -9, power) leaves either all of a commit or
// nothing of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace headstock::link {

/// An event to be kept. `body` is a JSON object as text, at most 64 KiB (see link/live_json.hpp:
/// `to_new_event`).
struct NewEvent {
  std::int64_t at_ms = 0;  ///< Unix time
  std::string kind;        ///< "part" "alarm" … as in protocol/wire/README.md
  std::string body;
};

struct SpooledEvent : NewEvent {
  std::uint64_t sequence = 0;  ///< grows by one with each event of this spool, never reused; the first is 1
};

/// A retained value, written with the events of the same commit. An empty optional erases it.
struct RetainedValue {
  std::string key;
  std::optional<std::string> value;
};

/// The spool cannot be opened or written. The message names the file and says what a person can do.
class SpoolError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};
/// The file is not a sound database. Nothing was changed; see Spool::set_aside.
class SpoolDamaged : public SpoolError {
 public:
  using SpoolError::SpoolError;
};

/// Any thread: the storage thread commits, the network thread reads and acknowledges.
class Spool {
 public:
  /// Opens or creates `file`. Throws SpoolDamaged when its content is damaged, SpoolError when it cannot be
  /// opened, is used by another process, or was written by a newer program.
  explicit Spool(std::filesystem::path file);
  ~Spool();
  Spool(const Spool&) = delete;
  Spool& operator=(const Spool&) = delete;

  /// Renames a damaged file (with its journal) to `<file>.damaged-<time>` so that a new one can be made while
  /// the old one stays for rescue. Never deletes. @return the new name. Throws SpoolError.
  static std::filesystem::path set_aside(const std::filesystem::path& file);

  /// Fixed when the file was made; the server recognises repeated events by it and their sequence.
  const std::string& id() const;

  /// Commits events and retained values in one transaction; on the disk when it returns.
  /// @return the sequence of the last event now in the spool. Throws SpoolError (disk full …): nothing was
  /// written.
  std::uint64_t commit(std::span<const NewEvent> events, std::span<const RetainedValue> retained = {});

  /// Events after `sequence`, oldest first, at most `at_most` of them and about `max_bytes` of bodies (at
  /// least one).
  std::vector<SpooledEvent> read_after(std::uint64_t sequence, std::size_t at_most = 256,
                                       std::size_t max_bytes = 512u << 10) const;
  /// The server has committed everything up to `sequence`: these events are removed.
  void acknowledge(std::uint64_t sequence);

  std::uint64_t last_sequence() const;
  std::uint64_t acknowledged() const;
  /// Events not yet acknowledged.
  std::uint64_t pending() const;

  std::optional<std::string> retained(std::string_view key) const;
  std::map<std::string, std::string> all_retained() const;

  /// Called after each commit with events, on the committing thread; must be quick. An empty function takes
  /// it off.
  void on_commit(std::function<void()> notify);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace headstock::link
