// What a control has to be told before it can go on in the middle of a program. Everything that the blocks
// before would have left in force is found by interpreting them, not by searching the text for codes; what
// cannot be brought back by a few plain blocks (compensation, cycles, variables) is refused, not guessed.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <map>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "server/library/check_setup.hpp"

namespace headstock::library {
namespace {

/// The interpreter's "the block before has been carried out": a dwell of a thousandth of a second in place of
/// the line.
constexpr std::string_view kMark = "\nG04 P1\n";

/// The text up to the line, then the mark.
class Beginning final : public program::Source {
 public:
  Beginning(const std::string& file, std::uint64_t end) : in_(file, std::ios::binary), end_(end) {}
  program::ReadResult read(std::span<char> buffer) override {
    std::size_t count = 0;
    if (at_ < end_) {
      count = static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), end_ - at_));
      in_.seekg(static_cast<std::streamoff>(at_));
      in_.read(buffer.data(), static_cast<std::streamsize>(count));
      if (static_cast<std::size_t>(in_.gcount()) != count) return {program::ReadStatus::failed, 0};
    } else if (at_ < end_ + kMark.size()) {
      const auto rest = kMark.substr(static_cast<std::size_t>(at_ - end_));
      count = std::min(buffer.size(), rest.size());
      std::memcpy(buffer.data(), rest.data(), count);
    } else {
      return {program::ReadStatus::end, 0};
    }
    at_ += count;
    return {program::ReadStatus::data, count};
  }
  bool seek(std::uint64_t offset) override {
    in_.clear();
    at_ = offset;
    return true;
  }

 private:
  std::ifstream in_;
  std::uint64_t at_ = 0, end_;
};

struct Text {
  std::uint64_t offset = 0;  ///< of the wanted line
  std::int64_t lines = 0;
  std::string first;         ///< the O line
  std::uint32_t number = 0;  ///< in it
  bool variables_behind = false, found = false;
};

Text look_at(const std::string& file, std::int64_t wanted) {
  Text text;
  std::ifstream in(file, std::ios::binary);
  std::string line;
  std::uint64_t at = 0;
  while (std::getline(in, line)) {
    ++text.lines;
    if (text.lines == wanted) {
      text.offset = at;
      text.found = true;
    }
    if (text.first.empty() && line.size() > 1 && (line[0] == 'O' || line[0] == ':')) {
      text.first = line;
      for (std::size_t i = 1; i < line.size() && i < 9 && line[i] >= '0' && line[i] <= '9'; ++i)
        text.number = text.number * 10 + static_cast<std::uint32_t>(line[i] - '0');
    }
    if (text.lines >= wanted) {
      bool comment = false;
      for (const char c : line) {
        comment = c == '(' || (comment && c != ')');
        text.variables_behind = text.variables_behind || (c == '#' && !comment);
      }
    }
    at += line.size() + 1;
  }
  while (!text.first.empty() && (text.first.back() == '\r' || text.first.back() == ' '))
    text.first.pop_back();
  return text;
}

/// Codes that one word brings back and those that mean that nothing is on. Besides these only what a reset
/// leaves in force anyway is accepted; all others are refused.
constexpr std::array<int, 22> kBroughtBack = {170, 180, 190, 200, 210, 540, 550, 560, 570, 580, 590,
                                              610, 640, 940, 950, 960, 970, 980, 990, 900, 910, 541};
constexpr std::array<int, 16> kNothingOn = {131, 150, 230, 260, 400, 401, 490, 500,
                                            501, 505, 670, 690, 800, 220, 250, 251};

template <std::size_t N>
bool among(const std::array<int, N>& codes, int code) {
  return std::ranges::find(codes, code) != codes.end();
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4f", value);
  std::string shown(text);
  while (shown.back() == '0') shown.pop_back();
  return shown == "-0." ? "0." : shown;
}

std::string code_text(int code) {
  std::string text(1, 'G');
  if (code < 100) text += '0';
  text += std::to_string(code / 10);
  if (code % 10 != 0) text.append(1, '.').append(std::to_string(code % 10));
  return text;
}

/// What is collected on the way besides the modal codes.
struct Seen {
  interp::ModalSnapshot after_reset, modal;
  interp::AxisVector end{};
  std::uint32_t moved = 0;
  interp::SpindleDirection spindle = interp::SpindleDirection::stop;
  int coolant = 9;
  std::int32_t tool = 0, offset = 0;
  bool has_tool = false, cycle = false, surface_speed = false;
};

void note(const interp::Operation& operation, Seen& seen) {
  std::visit(
      [&](const auto& one) {
        using T = std::decay_t<decltype(one)>;
        if constexpr (std::is_base_of_v<interp::Motion, T>) {
          seen.end = one.end_work;
          seen.moved |= one.axes;
          seen.cycle = one.cycle != nullptr;
        }
        if constexpr (std::is_same_v<T, interp::Spindle>) {
          seen.spindle = one.direction;
          seen.surface_speed = one.constant_surface_speed;
        }
        if constexpr (std::is_same_v<T, interp::Tool>) {
          seen.tool = one.tool;
          seen.offset = one.offset;
          seen.has_tool = true;
        }
        if constexpr (std::is_same_v<T, interp::MCode>)
          if (one.code == 7 || one.code == 8 || one.code == 9) seen.coolant = one.code;
      },
      operation);
}

/// @return a reason and what it is about, empty when plain blocks can bring everything back.
std::pair<std::string, std::string> obstacle(const Seen& seen) {
  for (std::size_t group = 0; group < seen.modal.g.size(); ++group) {
    const int code = seen.modal.g[group];
    if (code == seen.after_reset.g[group]) continue;
    if (code < 0 || (code >= 0 && code <= 30) || among(kBroughtBack, code) || among(kNothingOn, code))
      continue;
    if (code == 410 || code == 420 || code == 411 || code == 421)
      return {"restart_in_compensation", code_text(code)};
    if (code == 430 || code == 440) continue;
    return {"restart_mode", code_text(code)};
  }
  // G90, G92, G94 of a lathe are cycles of the motion group, with codes that are modes elsewhere.
  if (seen.cycle || seen.modal.g[1] > 30) return {"restart_in_cycle", ""};
  // Constant surface speed needs its speed limit (G50 S, G92 S) before the axis approaches the centre: not
  // guessed.
  if (seen.surface_speed) return {"restart_mode", "G96"};
  return {};
}

std::string header_of(const Seen& seen, const Setup& setup, const Text& text, std::int64_t line) {
  const bool mill = setup.machine.profile.ends_with("-m");
  std::string out = "%\n";
  if (!text.first.empty()) out += text.first + "\n";
  out += "(RESTART AT LINE " + std::to_string(line) + " - READ BEFORE START)\n";
  std::string codes;
  int motion = 0, length = 0;
  bool incremental = false;
  for (const int code : seen.modal.g) {
    // The header's own moves are absolute; G91 comes back behind them.
    incremental = incremental || code == 910;
    if (code == 910) continue;
    if (code >= 0 && code <= 30) motion = code;
    if (code == 430 || code == 440) length = code;
    // On a lathe of system A G90, G92, G94 are cycles of the motion group, never modes.
    const bool lathe_cycle = !mill && (code == 900 || code == 940) && setup.machine.profile == "fanuc-0i-t";
    if (code >= 0 && among(kBroughtBack, code) && !lathe_cycle)
      codes += (codes.empty() ? "" : " ") + code_text(code);
  }
  out += codes + "\n";
  const auto axis_word = [&](std::size_t axis) {
    return setup.machine.axes[axis].name + number(seen.end[axis]);
  };
  const auto index_of = [&](char name) -> std::ptrdiff_t {
    for (std::size_t i = 0; i < setup.machine.axes.size(); ++i)
      if (setup.machine.axes[i].name == name && (seen.moved & (1u << i)) != 0)
        return static_cast<std::ptrdiff_t>(i);
    return -1;
  };
  if (mill) {
    out += "G91 G28 Z0.\nG90\n";
  } else {
    out += "G28 U0.\nG28 W0.\n";
    if (incremental) out += "G90\n";
  }
  char word[32];
  if (seen.has_tool && mill) {
    out += "T" + std::to_string(seen.tool) + " M06\n";
  } else if (seen.has_tool) {
    std::snprintf(word, sizeof word, "T%02d%02d\n", seen.tool, seen.offset);
    out += word;
  }
  if (seen.spindle != interp::SpindleDirection::stop)
    out += "S" + std::to_string(std::lround(seen.modal.spindle_speed)) +
           (seen.spindle == interp::SpindleDirection::cw ? " M03\n" : " M04\n");
  const std::string feed = seen.modal.feed > 0 ? " F" + number(seen.modal.feed) : "";
  if (mill) {
    std::string plane = "G00";
    for (const char name : {'X', 'Y', 'A', 'B', 'C'})
      if (const auto axis = index_of(name); axis >= 0)
        plane += " " + axis_word(static_cast<std::size_t>(axis));
    if (plane != "G00") out += plane + "\n";
    out += "M00 (CLEAR OF THE PART?)\n";
    if (length != 0) out += code_text(length) + " H" + std::to_string(seen.modal.offset) + "\n";
    if (const auto z = index_of('Z'); z >= 0)
      out += "G01 " + axis_word(static_cast<std::size_t>(z)) + feed + "\n";
  } else {
    out += "M00 (CLEAR OF THE PART? Z FIRST, THEN X: CHANGE FOR BORING)\n";
    for (const char name : {'Z', 'X'})
      if (const auto axis = index_of(name); axis >= 0)
        out += "G01 " + axis_word(static_cast<std::size_t>(axis)) + feed + "\n";
  }
  if (seen.coolant != 9) out += seen.coolant == 8 ? "M08\n" : "M07\n";
  if (incremental) out += "G91\n";
  out += code_text(motion) + "\n";
  return out;
}

}  // namespace

Restart run_restart(const CheckJob& job, std::int64_t line) {
  Restart restart;
  const Text text = look_at(job.file, line);
  restart.lines = text.lines;
  restart.offset = text.offset;
  const auto refuse = [&](const char* reason, const std::string& where) {
    restart.reason = reason;
    restart.where = where;
    return restart;
  };
  if (!text.found || line < 2) return refuse("restart_not_reached", std::to_string(line));
  Setup setup;
  if (const std::string mistake = set_up(job, setup); !mistake.empty())
    return refuse("bad_machine_file", mistake);
  if (text.variables_behind) return refuse("restart_variables", "");
  const dialects::Dialect* dialect = dialects::find(setup.machine.profile);
  if (dialect == nullptr) return refuse("bad_profile", setup.machine.profile);
  interp::Interpreter interpreter(*dialect, setup.machine, setup.data, setup.neighbours.get());
  interp::AxisVector start{};
  for (std::size_t i = 0; i < setup.machine.axes.size(); ++i) start[i] = setup.machine.axes[i].reference_mm;
  Seen seen;
  seen.after_reset = interpreter.modal();
  interpreter.start(std::make_unique<Beginning>(job.file, text.offset), start);
  interp::Operation operation;
  for (std::int64_t count = 0; interpreter.next(operation) == interp::Pull::operation; ++count) {
    if (job.cancel != nullptr && (count & 1023) == 0 && *job.cancel) return refuse("cancelled", "");
    if (count > job.max_blocks) return refuse("restart_not_reached", std::to_string(line));
    if (const auto* alarm = std::get_if<interp::Alarm>(&operation))
      return refuse("restart_alarm", alarm->code + ", " + std::to_string(alarm->at.line));
    const auto* mark = std::get_if<interp::Dwell>(&operation);
    if (mark != nullptr && mark->at.byte_offset >= text.offset && mark->at.program == text.number) {
      seen.modal = mark->modal;
      if (const auto [reason, where] = obstacle(seen); !reason.empty()) return refuse(reason.c_str(), where);
      restart.header = header_of(seen, setup, text, line);
      return restart;
    }
    note(operation, seen);
  }
  return refuse("restart_not_reached", std::to_string(line));
}

}  // namespace headstock::library
