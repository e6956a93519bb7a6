// Any bytes at all through the interpreter: an alarm with line and column or a clean run, never a crash, a
// hang or unbounded memory. One program a profile (HEADSTOCK_PROFILE). First byte: G-code system, where the program
// comes from, a parameter that changes the language; second byte: how the text arrives, whether operations take
// time, whether an interruption comes; a run that is over is reset and begun again in its middle.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "machine/machine.hpp"
#include "macro/environment.hpp"
#include "program/library.hpp"

namespace {

using namespace headstock;

// Delivers in pieces, with waits between them; cannot seek.
class Dripping final : public program::Source {
 public:
  Dripping(std::string_view text, std::size_t piece) : text_(text), piece_(piece) {}
  program::ReadResult read(std::span<char> buffer) override {
    if (waiting_ = !waiting_; waiting_) return {program::ReadStatus::wait, 0};
    if (text_.empty()) return {program::ReadStatus::end, 0};
    const std::size_t bytes = std::min({piece_, text_.size(), buffer.size()});
    text_.copy(buffer.data(), bytes);
    text_.remove_prefix(bytes);
    return {program::ReadStatus::data, bytes};
  }
  bool seek(std::uint64_t) override { return false; }

 private:
  std::string_view text_;
  std::size_t piece_;
  bool waiting_ = false;
};

// A machine on which macros wait for a standstill and give way to others.
class Running final : public macro::Environment {
 public:
  bool takes_time() const override { return true; }
  bool wants_pause() override { return true; }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size < 2) return 0;
  constexpr std::string_view name = HEADSTOCK_PROFILE;
  constexpr std::string_view kParameters[] = {"",       "6000#5", "6000#4", "6005#0",  "6003#5",  "0000#2",
                                              "P001.2", "P004.2", "S001.2", "P4100.7", "P0002.1", "3401#0"};
  const std::size_t piece = bytes[1] & 0x0f;
  const std::string_view text(reinterpret_cast<const char*>(bytes + 2), size - 2);

  const machine::Machine machine = *machine::default_machine(name);
  interp::MachineData data;
  program::FilePrograms programs;
  programs.add_text(std::string(text));
  interp::Interpreter interpreter(*dialects::find(name), machine, data, &programs);
  interp::Switches switches;
  switches.gcode_system = static_cast<char>('A' + bytes[0] % 3);
  switches.origin = static_cast<interp::ProgramOrigin>(bytes[0] / 3 % 3);
  const std::string_view parameter = kParameters[bytes[0] / 9 % std::size(kParameters)];
  if (!parameter.empty()) data.parameters[std::string(parameter)] = 1;
  switches.lenient = (bytes[1] & 0x10) != 0;
  switches.block_skip = bytes[1] & 0x20 ? 0x3fe : 0;
  switches.most_jumps = 4'000;
  Running running;
  if ((bytes[1] & 0x40) != 0) interpreter.set_environment(&running);
  interpreter.set_switches(switches);
  interpreter.start(piece == 0 ? program::source_from_text(text)
                               : std::unique_ptr<program::Source>(std::make_unique<Dripping>(text, piece)),
                    {});
  interp::Operation operation;
  for (int i = 0; i < 20'000; ++i) {
    if ((bytes[1] & 0x80) != 0 && i % 3 == 2) (void)interpreter.interrupt({}, i % 2 == 0);
    const interp::Pull pull = interpreter.next(operation);
    if (pull == interp::Pull::finished) break;
    if (pull != interp::Pull::operation) continue;
    if (const auto* alarm = std::get_if<interp::Alarm>(&operation); alarm != nullptr && alarm->code.empty())
      std::abort();
  }
  interpreter.reset({});
  interp::RestartPoint point;
  point.block = 3;
  interp::Pull pull = interpreter.restart(program::source_from_text(text), {}, point);
  for (int i = 0; i < 100 && pull == interp::Pull::wait; ++i) pull = interpreter.run_through();
  for (int i = 0; i < 100 && pull != interp::Pull::finished; ++i) pull = interpreter.next(operation);
  return 0;
}
