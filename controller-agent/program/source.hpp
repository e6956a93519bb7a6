// Where program text comes from: a file, memory, or a link that is still delivering it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace headstock::program {

/// Outcome of one read.
enum class ReadStatus {
  data,   ///< at least one byte was written
  wait,   ///< nothing yet; more will come (drip-feed): ask again later
  end,    ///< no more bytes, ever
  failed  ///< the source broke; the interpreter raises the controller's input alarm
};

struct ReadResult {
  ReadStatus status = ReadStatus::end;
  std::size_t bytes = 0;
};

/// A stream of program bytes. One thread at a time. `seek` serves GOTO, M99 and rewinding; a drip-feed cannot
/// seek.
class Source {
 public:
  virtual ~Source() = default;
  virtual ReadResult read(std::span<char> buffer) = 0;
  /// @return false when this source cannot go there (a stream); then the dialect's alarm for jumps in DNC
  /// applies.
  virtual bool seek(std::uint64_t byte_offset) = 0;
};

/// The programs a controller can call: its memory, a folder (`--lib`), or the server's library.
class Programs {
 public:
  virtual ~Programs() = default;
  /// @param number O number.
  /// @return nullptr when there is no such program (the dialect's "program not found" alarm).
  virtual std::unique_ptr<Source> open_number(std::uint32_t number) = 0;
  /// M198: from the external device (memory card, data server) instead of the memory. Where there is none the
  /// memory serves.
  virtual std::unique_ptr<Source> open_external(std::uint32_t number) { return open_number(number); }
  /// @param name named programs (200T labels, file names).
  virtual std::unique_ptr<Source> open_name(std::string_view name) = 0;
};

/// Reads a whole text held in memory: a copy of its own.
std::unique_ptr<Source> source_from_text(std::string_view text);
/// The same without a copy. `text` outlives the source.
std::unique_ptr<Source> source_from_view(std::string_view text);
/// Reads a file in chunks. @return nullptr when it cannot be opened.
std::unique_ptr<Source> source_from_file(const std::string& path);

}  // namespace headstock::program
