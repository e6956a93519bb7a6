// The text of the block being executed, while the interpreter reads far ahead and a drip-fed program is
// nowhere else: the sources given to the interpreter keep the last part of what went through them. Look-ahead
// thread or under its lock.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "program/source.hpp"

namespace headstock::operation {

/// A window on the text of one program.
class TextWindow {
 public:
  void append(std::uint64_t offset, std::string_view bytes);
  /// The line that begins at this byte, without its end, at most 200 bytes; empty when it is not in the
  /// window any more.
  std::string line_at(std::uint64_t offset) const;
  /// The source behind it broke: what the interpreter says next is about that.
  bool broken = false;
  bool arrived = false;  ///< something of it has been read

 private:
  // Look-ahead of 4096 blocks at 100 bytes, and what the reader takes in one piece.
  static constexpr std::size_t kKept = 768u << 10;
  std::uint64_t begin_ = 0;
  std::string text_;
};

/// Wraps a source so that what is read stays visible.
std::unique_ptr<program::Source> windowed(std::unique_ptr<program::Source> source,
                                          std::shared_ptr<TextWindow> window);

/// The controller's program memory as the interpreter sees it: selected anew for each run, every text
/// windowed.
class WindowedPrograms final : public program::Programs {
 public:
  void select(std::shared_ptr<program::Programs> memory);
  std::unique_ptr<program::Source> open_number(std::uint32_t number) override;
  std::unique_ptr<program::Source> open_external(std::uint32_t number) override;
  std::unique_ptr<program::Source> open_name(std::string_view name) override;
  /// Text of a sub-program's line; empty when unknown.
  std::string line_at(std::uint32_t program, std::uint64_t offset) const;
  /// A program was asked for outside (M198) and nothing of it has come yet.
  bool awaited() const { return external_ && !external_->arrived; }
  bool knows(std::uint32_t program) const { return windows_.contains(program); }

 private:
  std::shared_ptr<program::Programs> memory_;
  std::map<std::uint32_t, std::shared_ptr<TextWindow>> windows_;
  std::shared_ptr<TextWindow> external_;  // of the last M198
};

/// Length of a source in bytes, by reading it to its end; 0 when it cannot be read.
std::uint64_t measure(program::Source& source);

}  // namespace headstock::operation
