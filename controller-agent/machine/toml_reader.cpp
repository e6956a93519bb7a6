// A machine file is read over the defaults of its profile, key by key against tables of what a section may
// hold: a key that is not in its table is an error, because a misspelt limit must not be ignored.
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <span>

#include "machine/machine.hpp"

namespace headstock::machine {
namespace {

constexpr std::string_view kAxisOrder = "XYZABCUVW";
constexpr std::string_view kDriveTypes[] = {"simulated", "ideal"};
constexpr std::string_view kHomings[] = {"absolute", "dog"};
constexpr std::size_t kMaxPitchPoints = 1'024;
constexpr std::size_t kMaxNameBytes = 64;

// Thrown only inside this file; the public functions turn it into a MachineError.
struct Failure {
  std::string message;
};

// Where a value stands, for messages: `lathe.toml:14: [axis.X] max_mm …`
struct Place {
  std::string_view file;
  std::string section;

  [[noreturn]] void fail(const toml::node& node, std::string_view what) const {
    throw Failure{fmt::format("{}:{}: [{}] {}", file, node.source().begin.line, section, what)};
  }
};

template <typename T>
struct Number {
  std::string_view key;
  double T::*member;
  double min, max;
  bool above_min = false;  // the value must be greater than min, not equal to it
};

struct Switch {
  std::string_view key;
  bool Axis::*member;
};

template <typename T>
struct WholeNumber {
  std::string_view key;
  int T::*member;
  int min, max;
};

/// The name of another axis.
template <typename T>
struct Letter {
  std::string_view key;
  char T::*member;
};

constexpr Number<Axis> kAxisNumbers[] = {
    {"rapid_mm_min", &Axis::rapid_mm_min, 0, 1e6, true},
    {"max_feed_mm_min", &Axis::max_feed_mm_min, 0, 1e6, true},
    {"max_acceleration_mm_s2", &Axis::max_acceleration_mm_s2, 0, 1e6, true},
    {"max_jerk_mm_s3", &Axis::max_jerk_mm_s3, 0, 1e12, true},
    {"min_mm", &Axis::min_mm, -1e6, 1e6},
    {"max_mm", &Axis::max_mm, -1e6, 1e6},
    {"reference_mm", &Axis::reference_mm, -1e6, 1e6},
    {"backlash_um", &Axis::backlash_um, 0, 1e3},
    {"emergency_deceleration_mm_s2", &Axis::emergency_deceleration_mm_s2, 0, 1e6},
    {"dog_mm", &Axis::dog_mm, -1e6, 1e6},
    {"dog_width_mm", &Axis::dog_width_mm, 0, 1e4, true},
    {"grid_mm", &Axis::grid_mm, 0, 1e3, true},
    {"creep_mm_min", &Axis::creep_mm_min, 0, 1e5, true},
    {"in_position_um", &Axis::in_position_um, 0, 1e4, true},
    {"following_error_mm", &Axis::following_error_mm, 0, 1e3},
    {"following_error_stopped_mm", &Axis::following_error_stopped_mm, 0, 1e3, true},
    {"position_gain_per_s", &Axis::position_gain_per_s, 0, 1e3, true},
    {"torque_reserve", &Axis::torque_reserve, 0, 1e3, true},
    {"friction_mm_s2", &Axis::friction_mm_s2, 0, 1e6},
    {"inertia_ratio", &Axis::inertia_ratio, 0, 1e3, true},
    {"encoder_um", &Axis::encoder_um, 0, 1e3},
    {"synchronous_error_mm", &Axis::synchronous_error_mm, 0, 1e3, true},
    {"inclined_deg", &Axis::inclined_deg, -85, 85},
};

constexpr Switch kAxisSwitches[] = {
    {"rotary", &Axis::rotary}, {"home_negative", &Axis::home_negative}, {"plc", &Axis::plc}};
constexpr WholeNumber<Axis> kAxisWholeNumbers[] = {{"gear_numerator", &Axis::gear_numerator, 0, 32'767},
                                                   {"gear_denominator", &Axis::gear_denominator, 1, 32'767}};
constexpr Letter<Axis> kAxisLetters[] = {{"follows", &Axis::follows}, {"inclined_to", &Axis::inclined_to}};

constexpr Number<Spindle> kSpindleNumbers[] = {
    {"max_rpm", &Spindle::max_rpm, 0, 200'000, true},
    {"min_rpm", &Spindle::min_rpm, 0, 200'000},
    {"acceleration_rpm_s", &Spindle::acceleration_rpm_s, 0, 1e7, true},
    {"tap_rpm", &Spindle::tap_rpm, 0, 200'000},
    {"tap_acceleration_rpm_s", &Spindle::tap_acceleration_rpm_s, 0, 1e7},
    {"position_error_deg", &Spindle::position_error_deg, 0, 1e5, true},
    {"orient_deg", &Spindle::orient_deg, 0, 360},
    {"orient_rpm", &Spindle::orient_rpm, 0, 200'000, true},
};
constexpr WholeNumber<Spindle> kSpindleWholeNumbers[] = {
    {"encoder_lines", &Spindle::encoder_lines, 1, 1'000'000},
    {"orient_m", &Spindle::orient_m, 0, 99'999'999},
    {"contour_on_m", &Spindle::contour_on_m, 0, 99'999'999},
    {"contour_off_m", &Spindle::contour_off_m, 0, 99'999'999}};
constexpr Letter<Spindle> kSpindleLetters[] = {{"contour_axis", &Spindle::contour_axis}};

std::string one_of(std::span<const std::string_view> choices) {
  std::string out;
  for (const auto choice : choices) out += (out.empty() ? "" : ", ") + fmt::format("\"{}\"", choice);
  return out;
}

double number(const toml::node& node, std::string_view key, double min, double max, bool above_min,
              const Place& place) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value) place.fail(node, fmt::format("{} must be a number", key));
  if (!std::isfinite(*value) || *value > max || *value < min || (above_min && *value <= min))
    place.fail(node, fmt::format("{} = {} is out of range: {} {} to {}", key, *value,
                                 above_min ? "above" : "from", min, max));
  return *value;
}

std::int64_t integer(const toml::node& node, std::string_view key, std::int64_t min, std::int64_t max,
                     const Place& place) {
  const auto value = node.is_integer() ? node.value<std::int64_t>() : std::nullopt;
  if (!value) place.fail(node, fmt::format("{} must be a whole number", key));
  if (*value < min || *value > max)
    place.fail(node, fmt::format("{} = {} is out of range: {} to {}", key, *value, min, max));
  return *value;
}

std::string text(const toml::node& node, std::string_view key, const Place& place) {
  const auto value = node.value<std::string>();
  if (!node.is_string() || !value) place.fail(node, fmt::format("{} must be text in quotes", key));
  const bool control = std::any_of(value->begin(), value->end(),
                                   [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; });
  if (value->empty() || value->size() > kMaxNameBytes || control)
    place.fail(node, fmt::format("{} must be 1 to {} bytes without control characters", key, kMaxNameBytes));
  return *value;
}

std::string choice(const toml::node& node, std::string_view key, std::span<const std::string_view> choices,
                   const Place& place) {
  auto value = text(node, key, place);
  if (std::find(choices.begin(), choices.end(), value) == choices.end())
    place.fail(node, fmt::format("{} = \"{}\" is not known: one of {}", key, value, one_of(choices)));
  return value;
}

std::vector<PitchError> pitch_error(const toml::node& node, const Place& place) {
  constexpr std::string_view what = "pitch_error must be an array of [position_mm, error_um] pairs";
  const auto* points = node.as_array();
  if (points == nullptr) place.fail(node, what);
  if (points->size() > kMaxPitchPoints)
    place.fail(node, fmt::format("pitch_error has more than {} points", kMaxPitchPoints));
  std::vector<PitchError> out;
  for (const toml::node& point : *points) {
    const auto* pair = point.as_array();
    if (pair == nullptr || pair->size() != 2) place.fail(point, what);
    out.push_back({number((*pair)[0], "pitch_error position_mm", -1e6, 1e6, false, place),
                   number((*pair)[1], "pitch_error error_um", -1e3, 1e3, false, place)});
    if (out.size() > 1 && out[out.size() - 2].position_mm >= out.back().position_mm)
      place.fail(point, "pitch_error positions must ascend");
  }
  return out;
}

const toml::table& table_of(const toml::node& node, const Place& place) {
  const auto* table = node.as_table();
  if (table == nullptr) place.fail(node, "must be a table");
  return *table;
}

template <typename T, std::size_t N>
bool read_number(T& into, const Number<T> (&numbers)[N], std::string_view key, const toml::node& node,
                 const Place& place) {
  const auto found = std::find_if(std::begin(numbers), std::end(numbers),
                                  [&](const auto& entry) { return entry.key == key; });
  if (found == std::end(numbers)) return false;
  into.*(found->member) = number(node, key, found->min, found->max, found->above_min, place);
  return true;
}

template <typename T, std::size_t N>
bool read_whole(T& into, const WholeNumber<T> (&numbers)[N], std::string_view key, const toml::node& node,
                const Place& place) {
  for (const auto& entry : numbers) {
    if (entry.key != key) continue;
    into.*(entry.member) = static_cast<int>(integer(node, key, entry.min, entry.max, place));
    return true;
  }
  return false;
}

bool switch_value(const toml::node& node, std::string_view key, const Place& place) {
  const auto value = node.value<bool>();
  if (!node.is_boolean() || !value) place.fail(node, fmt::format("{} must be true or false", key));
  return *value;
}

char letter(const toml::node& node, std::string_view key, const Place& place) {
  const std::string value = text(node, key, place);
  if (value.size() != 1 || kAxisOrder.find(value[0]) == std::string_view::npos)
    place.fail(node, fmt::format("{} = \"{}\" is not an axis: one of X Y Z A B C U V W", key, value));
  return value[0];
}

template <typename T, std::size_t N>
bool read_letter(T& into, const Letter<T> (&letters)[N], std::string_view key, const toml::node& node,
                 const Place& place) {
  for (const auto& entry : letters) {
    if (entry.key != key) continue;
    into.*(entry.member) = letter(node, key, place);
    return true;
  }
  return false;
}

void read_axis_key(Axis& axis, std::string_view key, const toml::node& node, const Place& place) {
  static constexpr std::string_view designations[] = {"radius", "diameter"};
  if (read_number(axis, kAxisNumbers, key, node, place)) return;
  if (read_whole(axis, kAxisWholeNumbers, key, node, place)) return;
  if (read_letter(axis, kAxisLetters, key, node, place)) return;
  for (const Switch& entry : kAxisSwitches) {
    if (entry.key != key) continue;
    axis.*(entry.member) = switch_value(node, key, place);
    return;
  }
  if (key == "homing") {
    axis.homing = choice(node, key, kHomings, place) == "dog" ? Homing::dog : Homing::absolute;
  } else if (key == "designation") {
    axis.designation =
        choice(node, key, designations, place) == "diameter" ? Designation::diameter : Designation::radius;
  } else if (key == "pitch_error") {
    axis.pitch_error = pitch_error(node, place);
  } else if (key == "pitch_error_negative") {
    axis.pitch_error_negative = pitch_error(node, place);
  } else {
    place.fail(node, fmt::format("{} is not a key of this section", key));
  }
}

void check_axis(const Axis& axis, const toml::node& node, const Place& place) {
  if (axis.max_mm <= axis.min_mm) place.fail(node, "max_mm must be greater than min_mm");
  if (axis.reference_mm < axis.min_mm || axis.reference_mm > axis.max_mm)
    place.fail(node, fmt::format("reference_mm = {} is outside min_mm … max_mm", axis.reference_mm));
  if (axis.rotary && axis.designation == Designation::diameter)
    place.fail(node, "a rotary axis cannot be diameter-designated");
}

/// Couplings name other axes: they must be there, and no axis may follow one that follows another.
void check_couplings(const Machine& machine, const toml::node& section, const Place& place) {
  const auto other = [&](const Axis& axis, char name, std::string_view key) -> const Axis& {
    const auto index = machine.axis_index(name);
    if (!index || name == axis.name)
      place.fail(section, fmt::format("{} of axis {} names {}, which is no other axis of this machine", key,
                                      axis.name, name));
    return machine.axes[*index];
  };
  for (const Axis& axis : machine.axes) {
    if (axis.follows != 0) {
      const Axis& master = other(axis, axis.follows, "follows");
      if (master.follows != 0)
        place.fail(section, fmt::format("axis {} follows {}, which follows itself", axis.name, axis.follows));
      if (master.rotary != axis.rotary)
        place.fail(section, fmt::format("axis {} follows {} of another kind", axis.name, axis.follows));
    }
    if ((axis.inclined_to != 0) != (axis.inclined_deg != 0))
      place.fail(section, fmt::format("axis {}: inclined_deg and inclined_to belong together", axis.name));
    if (axis.inclined_to != 0) {
      const Axis& straight = other(axis, axis.inclined_to, "inclined_to");
      if (straight.rotary || axis.rotary || straight.inclined_to != 0)
        place.fail(section, fmt::format("axis {}: an inclined axis and its perpendicular one are linear axes",
                                        axis.name));
    }
    if (axis.plc && axis.follows != 0)
      place.fail(section,
                 fmt::format("axis {} cannot be moved by the ladder and follow {}", axis.name, axis.follows));
  }
}

void read_axes(Machine& machine, const toml::node& section, std::string_view file) {
  for (const auto& [key, node] : table_of(section, {file, "axis"})) {
    const Place place{file, fmt::format("axis.{}", key.str())};
    if (key.str().size() != 1 || kAxisOrder.find(key.str()[0]) == std::string_view::npos)
      place.fail(node, "is not an axis: one of X Y Z A B C U V W");
    const char name = key.str()[0];
    // U, V and W are the incremental words of X, Y and Z on every lathe profile; an axis of that name could
    // not be told apart.
    if (machine.kind == Kind::lathe && name >= 'U' && name <= 'W')
      place.fail(node, fmt::format("a lathe cannot have an axis {}: it is the incremental word of {}", name,
                                   static_cast<char>(name + 3)));
    const auto index = machine.axis_index(name);
    Axis axis;
    if (index) {
      axis = machine.axes[*index];
    } else {
      axis.name = name;
      axis.rotary = name >= 'A' && name <= 'C';
    }
    for (const auto& [axis_key, value] : table_of(node, place))
      read_axis_key(axis, axis_key.str(), value, place);
    check_axis(axis, node, place);
    if (index)
      machine.axes[*index] = axis;
    else
      machine.axes.push_back(axis);
  }
  if (machine.axes.size() > kMaxAxes)
    Place{file, "axis"}.fail(section,
                             fmt::format("{} axes: a machine has at most {}", machine.axes.size(), kMaxAxes));
  std::sort(machine.axes.begin(), machine.axes.end(),
            [](const Axis& a, const Axis& b) { return kAxisOrder.find(a.name) < kAxisOrder.find(b.name); });
  check_couplings(machine, section, {file, "axis"});
}

void read_machine(Machine& machine, const toml::table& section, const Place& place) {
  static constexpr std::string_view kinds[] = {"lathe", "mill"};
  for (const auto& [key, node] : section) {
    if (key == "name")
      machine.name = text(node, key, place);
    else if (key == "kind")
      machine.kind = choice(node, key, kinds, place) == "mill" ? Kind::mill : Kind::lathe;
    else if (key == "period_us")
      machine.period_us = static_cast<int>(integer(node, key, 250, 8'000, place));
    else if (key == "second_auxiliary")
      machine.second_auxiliary = switch_value(node, key, place);
    else if (key == "skip_input")
      machine.skip_input = switch_value(node, key, place);
    else if (key == "interruption_input")
      machine.interruption_input = switch_value(node, key, place);
    else if (key == "polygon_axis")
      machine.polygon_axis = letter(node, key, place);
    else if (key != "profile")
      place.fail(node, fmt::format("{} is not a key of this section", key.str()));
  }
}

void read_spindle(Machine& machine, const toml::node& node, const Place& place) {
  for (const auto& [key, value] : table_of(node, place)) {
    if (read_number(machine.spindle, kSpindleNumbers, key.str(), value, place)) continue;
    if (read_whole(machine.spindle, kSpindleWholeNumbers, key.str(), value, place)) continue;
    if (read_letter(machine.spindle, kSpindleLetters, key.str(), value, place)) continue;
    place.fail(value, fmt::format("{} is not a key of this section", key.str()));
  }
  if (machine.spindle.min_rpm > machine.spindle.max_rpm)
    place.fail(node, "min_rpm must not be greater than max_rpm");
}

void read_path(Machine& machine, const toml::node& node, const Place& place) {
  bool degrees = false;
  for (const auto& [key, value] : table_of(node, place)) {
    if (key == "tolerance_mm") {
      machine.tolerance_mm = number(value, key, 0, 10, true, place);
    } else if (key == "tolerance_deg") {
      machine.tolerance_deg = number(value, key, 0, 10, true, place);
      degrees = true;
    } else {
      place.fail(value, fmt::format("{} is not a key of this section", key.str()));
    }
  }
  if (!degrees) machine.tolerance_deg = machine.tolerance_mm;
}

void read_drive(Machine& machine, const toml::node& node, const Place& place) {
  for (const auto& [key, value] : table_of(node, place)) {
    if (key != "type") place.fail(value, fmt::format("{} is not a key of this section", key.str()));
    machine.drive = choice(value, key, kDriveTypes, place);
  }
}

void read_memory(Machine& machine, const toml::node& node, const Place& place) {
  for (const auto& [key, value] : table_of(node, place)) {
    if (key != "programs_kb") place.fail(value, fmt::format("{} is not a key of this section", key.str()));
    machine.program_memory_bytes = static_cast<std::size_t>(integer(value, key, 1, 4 << 20, place)) * 1024;
  }
}

void read_axes_section(Machine& machine, const toml::node& node, const Place& place) {
  read_axes(machine, node, place.file);
}

struct Section {
  std::string_view name;
  void (*read)(Machine&, const toml::node&, const Place&);
};
constexpr Section kSections[] = {
    {"path", read_path},   {"axis", read_axes_section}, {"spindle", read_spindle},
    {"drive", read_drive}, {"memory", read_memory},
};

std::string profile_of(const toml::table* section, const Place& place) {
  const toml::node* node = section == nullptr ? nullptr : section->get("profile");
  return node == nullptr ? std::string() : text(*node, "profile", place);
}

Machine read(const toml::table& document, std::string_view where, std::string_view profile) {
  const Place place{where, "machine"};
  const toml::node* node = document.get("machine");
  const toml::table* section = node == nullptr ? nullptr : &table_of(*node, place);
  const std::string stated = profile_of(section, place);
  const std::string wanted = profile.empty() ? stated : std::string(profile);
  if (wanted.empty()) throw Failure{fmt::format("{}:1: [machine] profile is missing", where)};
  auto machine = default_machine(wanted);
  if (!machine)
    throw Failure{fmt::format("{}:{}: [machine] profile \"{}\" is not known", where,
                              section == nullptr ? 1 : section->source().begin.line, wanted)};

  if (section != nullptr) read_machine(*machine, *section, place);
  for (const auto& [key, value] : document) {
    if (key == "machine") continue;  // read first: the other sections stand over its profile and kind
    const std::string_view name = key.str();  // clang 14 does not let a lambda capture the binding itself
    const auto found = std::find_if(std::begin(kSections), std::end(kSections),
                                    [&](const Section& candidate) { return candidate.name == name; });
    if (found == std::end(kSections))
      Place{where, std::string(key.str())}.fail(value, "is not a section of a machine file");
    found->read(*machine, value, {where, std::string(key.str())});
  }
  for (const char name : {machine->spindle.contour_axis, machine->polygon_axis}) {
    if (name == 0) continue;
    const auto index = machine->axis_index(name);
    if (!index || !machine->axes[*index].rotary)
      throw Failure{fmt::format(
          "{}:1: contour_axis and polygon_axis must name a rotary axis of the machine, not {}", where, name)};
  }
  return *machine;
}

}  // namespace

MachineOrError parse_machine(std::string_view toml_text, std::string_view where, std::string_view profile) {
  try {
    return read(toml::parse(toml_text, where), where, profile);
  } catch (const toml::parse_error& error) {
    return MachineError{fmt::format("{}:{}: {}", where, error.source().begin.line, error.description())};
  } catch (const Failure& failure) {
    return MachineError{failure.message};
  }
}

MachineOrError load_machine(const std::filesystem::path& file, std::string_view profile) {
  constexpr std::uintmax_t most_bytes = 1 << 20;
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  if (error) return MachineError{fmt::format("{}: cannot be read: {}", file.string(), error.message())};
  if (size > most_bytes)
    return MachineError{fmt::format("{}: larger than a machine file can be", file.string())};
  std::ifstream in(file, std::ios::binary);
  const std::string content((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in) return MachineError{fmt::format("{}: cannot be read", file.string())};
  return parse_machine(content, file.string(), profile);
}

}  // namespace headstock::machine
