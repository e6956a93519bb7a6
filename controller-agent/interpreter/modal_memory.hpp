// What RESET goes back to. The look-ahead reads blocks long before they are carried out; a RESET in the middle of a
// program must not leave a G91, a G55 or a tool offset of a block that nobody has seen run (0i-D K.32.1: the modal
// state is that of the last block carried out whole). The block that ended in an alarm was not carried out either.
// One object a path, the interpreter's thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/canonical.hpp"

namespace headstock::interp {

struct Executor;
struct KeptModes;

class ModalMemory {
 public:
  /// States kept at most: as many changes as the moves of a look-ahead. Older ones belong to blocks long done.
  static constexpr std::size_t kMost = 4'096;

  ModalMemory();
  ~ModalMemory();
  ModalMemory(const ModalMemory&) = delete;
  ModalMemory& operator=(const ModalMemory&) = delete;

  /// The next block is read: the one before is done.
  void block_done() {
    if (!held_) open_ = 0;
  }
  /// Before the block read last is carried out: keeps the state if the block may change more than positions.
  void before_block(const Executor& ex);
  /// The program ends in an alarm here, or in one about a block before.
  void alarm_raised() { failed_ = open_; }
  void alarm_raised(std::uint32_t block) { failed_ = block; }
  /// Blocks are read on for the sake of the one being carried out (a profile); their state is put back by who reads.
  void hold(bool on) { held_ = on; }
  /// The block whose alarm ended the program; 0: none, or it had not begun.
  std::uint32_t failed_block() const { return failed_; }
  /// A program begins.
  void forget();
  /// The modes as they were before this block (SourcePosition::block); nothing when nothing has changed since.
  void back_to(Executor& ex, std::uint32_t block);

 private:
  /// Before a block. Most change G00 to G01 or G01 to G02 and nothing else: the whole state is that of the next entry
  /// that has it, or the one in force.
  struct Entry {
    std::uint32_t block = 0;  ///< number of the block before which it was so
    bool whole = false;       ///< `whole_` has a state of this block
    const dialects::GCode* motion_code = nullptr;
    std::array<std::int16_t, kModalGroups> g{};
  };
  Entry& add(std::uint32_t block);
  void keep(const Executor& ex);
  std::vector<Entry> entries_;    // a ring: `begin_` is the oldest of `count_`
  std::vector<KeptModes> whole_;  // a ring likewise, of those entries that are whole
  std::size_t begin_ = 0, count_ = 0, whole_begin_ = 0, whole_count_ = 0;
  std::uint32_t open_ = 0;    // the block being carried out
  std::uint32_t failed_ = 0;
  bool held_ = false;
};

}  // namespace headstock::interp
