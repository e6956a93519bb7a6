// A program that is still arriving while it runs: a bounded buffer between the link (one thread) and the
// interpreter (another).
//
// The buffer never holds more than was granted to the server, so memory stays bounded however long the
// program is. The running hash covers every byte taken in; both ends compare it with each credit, so a
// resumed feed loses and repeats nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "program/source.hpp"

namespace headstock::link {

class DripFeed : public std::enable_shared_from_this<DripFeed> {
 public:
  struct Announced {
    std::uint64_t transfer = 0;
    std::string name;
    std::uint64_t bytes = 0;
    std::string sha256;
  };
  /// What to grant the server next.
  struct Grant {
    std::uint64_t offset = 0;  ///< received and hashed so far
    std::string prefix_sha256;
    std::uint64_t granted = 0;  ///< bytes beyond offset
  };
  enum class Outcome { running, drained, closed, failed };
  struct State {
    Outcome outcome = Outcome::running;
    std::uint64_t received = 0, buffered = 0;
    std::string reason;  ///< of failed
  };

  /// @param buffer_bytes 64 KiB…64 MiB
  /// @param wake called (on any thread) when there is room to grant, or the outcome changed.
  static std::shared_ptr<DripFeed> make(Announced announced, std::size_t buffer_bytes,
                                        std::function<void()> wake);
  ~DripFeed();

  const Announced& announced() const;

  // ---- the link's thread
  /// @return false when these bytes were never granted: the feed has failed.
  bool append(std::string_view bytes);
  /// The server says this is all. @return false when length or hash are wrong: the feed has failed.
  bool finish(std::uint64_t bytes, const std::string& sha256);
  /// Ends the feed: the interpreter gets `failed` at once.
  void fail(const std::string& reason);
  /// What may be granted now, when it is worth a message (a quarter of the buffer, or the rest of the
  /// program).
  std::optional<Grant> grant();
  /// Where the feed stands, for a first credit or after a reconnect. @return nullopt when it has ended.
  std::optional<Grant> resume();
  State state() const;

  // ---- the interpreter's thread
  /// The stream to run from; once. Destroying it before its end was read is the outcome `closed`.
  std::unique_ptr<program::Source> source();

 private:
  friend class DripSource;
  struct Impl;
  explicit DripFeed(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace headstock::link
