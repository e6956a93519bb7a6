// What a dialect adds that is more than a table: memory of its own, and the places where it reads a block as
// text before the lexer does. One object a path, made by the dialect (Dialect::make_own); most dialects have
// none. Belongs to the interpreter's thread.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

namespace headstock::program {
struct Code;
}

namespace headstock::interp {

struct Executor;
struct Frame;
struct Motion;

/// What a program's blocks change in a language's own memory and RESET takes back with the modes.
struct OwnModes {
  OwnModes() = default;
  virtual ~OwnModes() = default;
  OwnModes(const OwnModes&) = default;
  OwnModes& operator=(const OwnModes&) = default;
};

class OwnLanguage {
 public:
  virtual ~OwnLanguage() = default;
  OwnLanguage() = default;
  OwnLanguage(const OwnLanguage&) = delete;
  OwnLanguage& operator=(const OwnLanguage&) = delete;

  /// What the dialect says instead of plain reading.
  enum class Taken : std::uint8_t {
    plain,  ///< read on as every control does
    done    ///< the block was carried out, left out, or raised an alarm
  };

  /// Power-on codes come into force.
  virtual void power_on(Executor&) {}
  /// A main program begins.
  virtual void start(Executor&) {}
  /// RESET; the program has been left.
  virtual void reset(Executor&) {}
  /// Room for its modes, nullptr: it has none; then what they are now, and back to what they were (modal_memory.hpp).
  virtual std::unique_ptr<OwnModes> make_modes() const { return nullptr; }
  virtual void keep_modes(OwnModes&) const {}
  virtual void restore_modes(const OwnModes&) {}
  /// Before a block of `frame` is read: block loops end here.
  virtual Taken before_block(Executor&, Frame&) { return Taken::plain; }
  /// `frame.line` and `frame.rest` are the text to read; both may be replaced by text that lives as long as
  /// the line.
  virtual Taken take_text(Executor&, Frame&) { return Taken::plain; }
  /// A block that begins like a macro statement. `plain`: it is none of the dialect's.
  virtual Taken statement(Executor&, std::string_view /*text*/, std::uint32_t /*column*/) {
    return Taken::plain;
  }
  /// A block of words, read and not yet carried out.
  virtual Taken take_block(Executor&) { return Taken::plain; }
  /// A motion has its end: the last word on it.
  virtual void moved(Executor&, Motion&) {}
  /// The text of `frame` is over. @return false after an alarm.
  virtual bool end_of_text(Executor&, Frame&) { return true; }
  /// The block's S word. `done`: it was not a speed.
  virtual Taken take_spindle(Executor&) { return Taken::plain; }
  /// An M code whose MAction is `own`, after the block's motion. @return false after an alarm.
  virtual bool m_code(Executor&, const program::Code&) { return true; }
};

}  // namespace headstock::interp
