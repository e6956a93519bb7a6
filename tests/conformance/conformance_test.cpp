// Runs every file of cases/: the program through the interpreter, each operation against what the case
// expects.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "case_file.hpp"
#include "dialects/catalogue.hpp"
#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "program/library.hpp"

namespace headstock::conformance {
namespace {

namespace fs = std::filesystem;
using Values = std::map<std::string, double>;

// An operation in the case file's words.
struct Seen {
  std::string op, word;
  Values values;
  std::string text() const {
    std::ostringstream out;
    out << op << (word.empty() ? "" : " " + word);
    for (const auto& [key, value] : values) out << ' ' << key << '=' << value;
    return out.str();
  }
};

void add_axes(Seen& seen, const machine::Machine& machine, const std::string& before,
              const machine::AxisVector& values) {
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    seen.values[before + machine.axes[i].name] = values[i];
}

void add_feed(Seen& seen, double feed, interp::FeedUnit unit) {
  seen.values[unit == interp::FeedUnit::mm_per_revolution ? "fr" : "f"] = feed;
}

// A text as one word: blanks as _, bytes that are no characters as \xNN.
std::string one_word(const std::string& text) {
  std::string word;
  for (const char c : text) {
    char hex[8];
    std::snprintf(hex, sizeof hex, "\\x%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
    word += c == ' '              ? "_"
            : c == '\n'           ? "\\n"
            : c == '\r'           ? "\\r"
            : c > ' ' && c < 0x7f ? std::string(1, c)
                                  : hex;
  }
  return word;
}

Seen describe(const interp::Operation& operation, const machine::Machine& machine) {
  Seen seen;
  const auto common = [&](const char* op, const interp::Motion& m) {
    seen.op = op;
    add_axes(seen, machine, "", m.end_work);
    add_axes(seen, machine, "m", m.end_machine);
    seen.values["exact"] = m.exact_stop ? 1 : 0;
  };
  std::visit(
      [&](const auto& op) {
        using T = std::decay_t<decltype(op)>;
        if constexpr (std::is_same_v<T, interp::Rapid>) {
          common("rapid", op);
          seen.values["away"] = op.retreat_ratio;
        } else if constexpr (std::is_same_v<T, interp::Feed>) {
          common("feed", op);
          seen.values["input"] = op.skip_input;
          seen.values["level"] = op.skip_level ? 1 : 0;
          add_feed(seen, op.feed, op.unit);
          seen.values["skip"] = op.skip_signals;
        } else if constexpr (std::is_same_v<T, interp::Arc>) {
          common("arc", op);
          add_feed(seen, op.feed, op.unit);
          seen.word = op.turn == interp::Turn::cw ? "cw" : "ccw";
          add_axes(seen, machine, "c", op.center_work);
          seen.values["r"] = op.radius_mm;
          seen.values["turns"] = op.turns;
          seen.values["degrees"] = op.turns * 360;
        } else if constexpr (std::is_same_v<T, interp::Thread>) {
          common("thread", op);
          seen.values["lead"] = op.lead_mm;
          seen.values["change"] = op.lead_change_mm;
          seen.values["angle"] = op.start_angle_deg;
        } else if constexpr (std::is_same_v<T, interp::Tap>) {
          common("tap", op);
          seen.word = op.direction == interp::SpindleDirection::ccw ? "ccw" : "cw";
          add_axes(seen, machine, "b", op.bottom_work);
          seen.values["pitch"] = op.pitch_mm;
          seen.values["rpm"] = op.rpm;
          seen.values["s"] = op.dwell_s;
        } else if constexpr (std::is_same_v<T, interp::Dwell>) {
          seen.op = "dwell";
          seen.values["s"] = op.seconds;
          seen.values["rev"] = op.revolutions;
          seen.values["skip"] = op.skip_signals;
        } else if constexpr (std::is_same_v<T, interp::Spindle>) {
          seen.op = "spindle";
          seen.word = op.direction == interp::SpindleDirection::stop ? "stop"
                      : op.direction == interp::SpindleDirection::cw ? "cw"
                                                                     : "ccw";
          seen.values[op.constant_surface_speed ? "m_min" : "rpm"] = op.speed;
          seen.values["clamp"] = op.clamp_rpm;
          seen.values["gear"] = op.gear;
        } else if constexpr (std::is_same_v<T, interp::Tool>) {
          seen.op = "tool";
          seen.values["tool"] = op.tool;
          seen.values["offset"] = op.offset;
        } else if constexpr (std::is_same_v<T, interp::MCode>) {
          seen.op = "m";
          seen.values["code"] = op.code;
          seen.values["after"] = op.after_motion ? 1 : 0;
          seen.values["delay"] = op.delay_s;
          seen.values["axis"] = op.at_axis;
          seen.values["at"] = op.at_position;
          seen.values["input"] = op.input;
          seen.values["level"] = op.input_level ? 1 : 0;
          seen.values["counts"] = op.counts_part ? 1 : 0;
          seen.values["clears"] = op.clears_parts ? 1 : 0;
        } else if constexpr (std::is_same_v<T, interp::Message>) {
          seen.op = "message";
          seen.word = op.kind == interp::MessageKind::open        ? "open"
                      : op.kind == interp::MessageKind::close     ? "close"
                      : op.kind == interp::MessageKind::statement ? "statement"
                                                                  : one_word(op.text);
        } else if constexpr (std::is_same_v<T, interp::Stop>) {
          seen.op = "stop";
        } else if constexpr (std::is_same_v<T, interp::Alarm>) {
          seen.op = "alarm";
          seen.word = op.code;
          seen.values["column"] = op.at.column;
        } else if constexpr (std::is_same_v<T, interp::ContourMode>) {
          seen.op = "contour_mode";
          seen.word = op.on ? "on" : "off";
          seen.values["level"] = op.level;
          seen.values["f"] = op.reference_feed;
        } else if constexpr (std::is_same_v<T, interp::StrokeCheck>) {
          seen.op = "stroke_check";
          seen.word = op.on ? "on" : "off";
          add_axes(seen, machine, "most", op.most);
          add_axes(seen, machine, "least", op.least);
          seen.values["outside"] = op.outside_forbidden ? 1 : 0;
        } else if constexpr (std::is_same_v<T, interp::SpindleWatch>) {
          seen.op = "spindle_watch";
          seen.word = op.on ? "on" : "off";
          seen.values["s"] = op.delay_s;
          seen.values["reached"] = op.reached_ratio;
          seen.values["ratio"] = op.ratio;
          seen.values["rpm"] = op.width_rpm;
        } else if constexpr (std::is_same_v<T, interp::PolygonTurning>) {
          seen.op = "polygon";
          seen.word = op.on ? "on" : "off";
          seen.values["p"] = op.spindle_ratio;
          seen.values["q"] = op.tool_ratio;
        } else if constexpr (std::is_same_v<T, interp::SecondAuxiliary>) {
          seen.op = "aux";
          seen.values["code"] = static_cast<double>(op.code);
        } else {
          seen.op = "end";
          constexpr const char* kReasons[] = {"m02", "m30", "m99", "end_of_file", "alarm"};
          seen.word = kReasons[static_cast<std::size_t>(op.reason)];
          seen.values["counts"] = op.counts_part ? 1 : 0;
        }
        seen.values["line"] = op.at.line;
        seen.values["program"] = op.at.program;
        seen.values["n"] = op.at.sequence;
        seen.values["part"] = op.at.part;
      },
      operation);
  return seen;
}

// Half a unit of the last digit written, and the sixth decimal at least.
double tolerance_of(const std::string& number) {
  const auto point = number.find('.');
  const std::size_t decimals = point == number.npos ? 0 : number.size() - point - 1;
  return std::max(1e-6, decimals < 3 ? 1e-4 : 0.51 * std::pow(10.0, -static_cast<double>(decimals)));
}

std::string compare(const Expected& expected, const Seen& seen) {
  if (expected.op != seen.op) return "expected " + expected.op;
  if (!expected.word.empty() && expected.word != seen.word) return "expected " + expected.word;
  for (const auto& [key, text] : expected.values) {
    const auto found = seen.values.find(key);
    if (found == seen.values.end()) return "has no " + key;
    if (!(std::fabs(found->second - std::stod(text)) <= tolerance_of(text)))
      return "expected " + key + "=" + text;
  }
  return {};
}

// "X20 Z46" in what the position page shows.
machine::AxisVector position(const std::string& text, const machine::Machine& machine) {
  machine::AxisVector at{};
  std::istringstream words(text);
  std::string word;
  while (words >> word) {
    const auto axis = machine.axis_index(word[0]);
    if (!axis) continue;
    const bool diameter = machine.axes[*axis].designation == machine::Designation::diameter;
    at[*axis] = std::stod(word.substr(1)) * (diameter ? 0.5 : 1);
  }
  return at;
}

machine::Machine machine_of(const Case& one, const std::string& profile) {
  machine::Machine machine = *machine::default_machine(profile);
  if (const auto wanted = one.settings.find("axes"); wanted != one.settings.end()) {
    std::istringstream names(wanted->second);
    std::string name;
    while (names >> name) {
      if (machine.axis_index(name[0])) continue;
      machine::Axis axis;
      axis.name = name[0];
      axis.rotary = name[0] <= 'C';
      machine.axes.push_back(axis);
    }
  }
  if (one.settings.count("radius_x") != 0)
    machine.axes[*machine.axis_index('X')].designation = machine::Designation::radius;
  return machine;
}

// `collapse: yes`: moves of one kind from one line become one, with their number and the extremes they
// reached.
bool collapse(Seen& next, std::vector<Seen>& seen, const machine::Machine& machine) {
  next.values["count"] = 1;
  for (const auto& axis : machine.axes) {
    next.values[std::string("min") + axis.name] = next.values[std::string(1, axis.name)];
    next.values[std::string("max") + axis.name] = next.values[std::string(1, axis.name)];
  }
  if (next.op != "feed" || seen.empty() || seen.back().op != next.op ||
      seen.back().values["line"] != next.values["line"])
    return false;
  Seen& last = seen.back();
  const Seen before = last;
  last = next;
  last.values["count"] = before.values.at("count") + 1;
  for (const auto& axis : machine.axes) {
    const std::string least = std::string("min") + axis.name, most = std::string("max") + axis.name;
    last.values[least] = std::min(before.values.at(least), next.values[least]);
    last.values[most] = std::max(before.values.at(most), next.values[most]);
  }
  return true;
}

class NamedPrograms final : public program::Programs {
 public:
  explicit NamedPrograms(const Case& one) : case_(one) {
    numbered_.add_text(one.program);
    numbered_.add_text(one.others);
  }
  std::unique_ptr<program::Source> open_number(std::uint32_t number) override {
    return numbered_.open_number(number);
  }
  std::unique_ptr<program::Source> open_name(std::string_view name) override {
    const auto found = case_.named.find(std::string(name));
    return found == case_.named.end() ? nullptr : program::source_from_text(found->second);
  }

 private:
  const Case& case_;
  program::FilePrograms numbered_;
};

bool apply_settings(const std::string& settings, interp::Switches& switches) {
  std::istringstream words(settings);
  std::string word;
  while (words >> word) {
    if (word.rfind("gcode_system=", 0) == 0) {
      switches.gcode_system = word.back();
    } else if (word == "lenient=true") {
      switches.lenient = true;
    } else if (word == "decimal_point=pocket") {
      switches.decimal_point = interp::DecimalPoint::pocket;
    } else if (word == "decimal_point=standard") {
      switches.decimal_point = interp::DecimalPoint::standard;
    } else if (word.rfind("most_jumps=", 0) == 0) {
      switches.most_jumps = std::stoull(word.substr(11));
    } else if (word == "origin=mdi") {
      switches.origin = interp::ProgramOrigin::mdi;
    } else if (word == "origin=dnc") {
      switches.origin = interp::ProgramOrigin::dnc;
    } else if (word == "optional_stop=true") {
      switches.optional_stop = true;
    } else if (word.rfind("block_skip=", 0) == 0) {
      switches.block_skip |= 1u << (word.back() - '0');
    } else {
      return false;
    }
  }
  return true;
}

std::vector<fs::path> case_files() {
  std::vector<fs::path> files;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(HEADSTOCK_SOURCE_DIR) / "tests/conformance/cases")) {
    if (entry.path().extension() == ".case") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// `skip_at: X198`: the next probe move ends there; `-`: no signal comes.
void end_probe(interp::Interpreter& interpreter, const interp::Operation& operation,
               const machine::Machine& machine, std::istream& places) {
  const auto* probe = std::get_if<interp::Feed>(&operation);
  std::string place;
  if (probe == nullptr || probe->skip_signals == 0 || !(places >> place)) return;
  machine::AxisVector at = probe->end_machine;
  const auto axis = machine.axis_index(place[0]);
  if (axis) {
    const bool diameter = machine.axes[*axis].designation == machine::Designation::diameter;
    at[*axis] += (std::stod(place.substr(1)) - probe->end_work[*axis]) * (diameter ? 0.5 : 1);
  }
  interpreter.skip_ended(at, axis.has_value());
}

class Conformance : public testing::TestWithParam<fs::path> {};

TEST_P(Conformance, AsTheManualSays) {
  std::string mistake;
  const Case one = read_case(GetParam(), mistake);
  ASSERT_EQ(mistake, "") << GetParam();
  const auto setting = [&](const std::string& key) {
    const auto found = one.settings.find(key);
    return found == one.settings.end() ? std::string() : found->second;
  };
  const std::string profile = setting("profile");
  const dialects::Dialect* dialect = dialects::find(profile);
  ASSERT_NE(dialect, nullptr) << profile;
  const machine::Machine machine = machine_of(one, profile);

  interp::MachineData data;
  std::vector<char> names;
  for (const auto& axis : machine.axes) names.push_back(axis.name);
  if (!setting("offsets").empty()) {
    ASSERT_EQ(interp::load_offsets(setting("offsets"), names, data), "");
  }
  if (!setting("params").empty()) {
    ASSERT_EQ(interp::load_parameters(setting("params"), data), "");
  }
  interp::Switches switches;
  ASSERT_TRUE(apply_settings(setting("set"), switches)) << setting("set");

  NamedPrograms programs(one);
  interp::Interpreter interpreter(*dialect, machine, data, &programs);
  const std::string show = " " + setting("show") + " ";
  std::vector<Seen> seen;
  if (show.find(" data ") != show.npos) {
    interpreter.on_data_change([&seen](const interp::DataChange& change) {
      seen.push_back({"data", change.what, {{"before", change.before}, {"after", change.after}}});
    });
  }
  interpreter.set_switches(switches);
  interpreter.start(program::source_from_text(one.program), position(setting("start"), machine));

  std::istringstream probes(setting("skip_at"));
  interp::Operation operation;
  while (seen.size() < 1'000 && interpreter.next(operation) == interp::Pull::operation) {
    Seen next = describe(operation, machine);
    // MC: the program's own, by #3000.
    if (next.op == "alarm" && next.word != "HS0001" && !next.word.starts_with("MC")) {
      dialects::Alarm row;
      EXPECT_TRUE(dialects::find_alarm(profile, next.word, row))
          << next.word << " is not in the catalogue of " << profile;
    }
    if (!setting("collapse").empty() && collapse(next, seen, machine)) continue;
    if (show == "  " || show.find(" " + next.op + " ") != show.npos || next.op == "alarm")
      seen.push_back(next);
    end_probe(interpreter, operation, machine, probes);
  }
  for (std::size_t i = 0; i < std::max(seen.size(), one.expected.size()); ++i) {
    ASSERT_LT(i, one.expected.size()) << GetParam().string() << ": more than expected: " << seen[i].text();
    const Expected& expected = one.expected[i];
    ASSERT_LT(i, seen.size()) << GetParam().string() << ":" << expected.file_line
                              << ": not made: " << expected.op;
    const std::string difference = compare(expected, seen[i]);
    ASSERT_EQ(difference, "") << GetParam().string() << ":" << expected.file_line << ": made "
                              << seen[i].text();
  }
}

std::string name_of(const testing::TestParamInfo<fs::path>& info) {
  std::string name = info.param.parent_path().filename().string() + "_" + info.param.stem().string();
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
}

INSTANTIATE_TEST_SUITE_P(Manual, Conformance, testing::ValuesIn(case_files()), name_of);

}  // namespace
}  // namespace headstock::conformance
