#include "interpreter/machine_data.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "tools/tool_life_json.hpp"

namespace headstock::interp {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostTools = 1'000;

// Collects the first mistake with its place; everything after it is ignored.
class Reader {
 public:
  explicit Reader(const std::vector<char>& axis_names) : axis_names_(axis_names) {}

  const std::string& mistake() const { return mistake_; }
  void fail(const std::string& where, const std::string& what) {
    if (mistake_.empty()) mistake_ = where + ": " + what;
  }

  double number(const Json& value, const std::string& where) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) {
      fail(where, "must be a number");
      return 0;
    }
    return value.get<double>();
  }

  void axis_values(const Json& object, const std::string& where, AxisVector& out) {
    if (!object.is_object()) return fail(where, "must be an object of axis letters");
    for (const auto& [key, value] : object.items()) {
      const auto axis =
          key.size() == 1 ? std::find(axis_names_.begin(), axis_names_.end(), key[0]) : axis_names_.end();
      if (axis == axis_names_.end()) return fail(where + "/" + key, "the machine has no such axis");
      out[static_cast<std::size_t>(axis - axis_names_.begin())] = number(value, where + "/" + key);
    }
  }

  // "G54" … "G59", "G54.1P7".
  AxisVector* work_system(const std::string& name, MachineData& data) {
    if (name.size() == 3 && name.compare(0, 2, "G5") == 0 && name[2] >= '4' && name[2] <= '9') {
      return &data.work[static_cast<std::size_t>(name[2] - '4')];
    }
    if (name.size() > 6 && name.compare(0, 6, "G54.1P") == 0 &&
        name.find_first_not_of("0123456789", 6) == name.npos && name.size() < 9) {
      const int p = std::stoi(name.substr(6));
      if (p >= 1 && p <= 48) return &data.work_extra[static_cast<std::size_t>(p - 1)];
    }
    return nullptr;
  }

  void tool(const Json& object, const std::string& where, ToolOffset& out) {
    if (!object.is_object()) return fail(where, "must be an object");
    const auto z = std::find(axis_names_.begin(), axis_names_.end(), 'Z');
    const auto z_index = static_cast<std::size_t>(z - axis_names_.begin());
    for (const auto& [key, value] : object.items()) {
      const std::string place = where + "/" + key;
      if (key == "geometry") {
        axis_values(value, place, out.geometry);
      } else if (key == "wear") {
        axis_values(value, place, out.wear);
      } else if (key == "radius") {
        out.radius = number(value, place);
      } else if (key == "radius_wear") {
        out.radius_wear = number(value, place);
      } else if (key == "tip") {
        out.tip = static_cast<int>(number(value, place));
        if (out.tip < 0 || out.tip > 9) return fail(place, "must be 0 to 9");
      } else if (key == "length" && z != axis_names_.end()) {
        out.geometry[z_index] = number(value, place);
      } else if (key == "length_wear" && z != axis_names_.end()) {
        out.wear[z_index] = number(value, place);
      } else {
        return fail(place, "unknown key");
      }
    }
  }

 private:
  const std::vector<char>& axis_names_;
  std::string mistake_;
};

std::optional<Json> parse(const std::string& text, std::string& mistake) {
  try {
    Json root = Json::parse(text);
    if (root.is_object()) return root;
    mistake = "must be a JSON object";
  } catch (const Json::parse_error& error) {
    mistake = error.what();
  }
  return std::nullopt;
}

Json axis_object(const AxisVector& values, const std::vector<char>& names) {
  Json object = Json::object();
  for (std::size_t i = 0; i < names.size() && i < values.size(); ++i)
    object[std::string(1, names[i])] = values[i];
  return object;
}

bool is_zero(const AxisVector& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return value == 0; });
}

}  // namespace

double MachineData::parameter(std::string_view number, double otherwise) const {
  if (number.empty()) return otherwise;
  const auto found = parameters.find(number);
  return found == parameters.end() ? otherwise : found->second;
}

std::string load_offsets(const std::string& json_text, const std::vector<char>& axis_names,
                         MachineData& into) {
  std::string mistake;
  const auto root = parse(json_text, mistake);
  if (!root) return mistake;
  MachineData read = into;
  Reader reader(axis_names);
  for (const auto& [key, value] : root->items()) {
    if (key == "external") {
      reader.axis_values(value, key, read.work_external);
    } else if (key == "shift") {
      reader.axis_values(value, key, read.work_shift);
    } else if (key == "work" && value.is_object()) {
      for (const auto& [name, axes] : value.items()) {
        AxisVector* system = reader.work_system(name, read);
        if (system == nullptr) return "work/" + name + ": no such coordinate system";
        reader.axis_values(axes, "work/" + name, *system);
      }
    } else if (key == "tools" && value.is_object()) {
      for (const auto& [name, tool] : value.items()) {
        const bool digits =
            !name.empty() && name.size() < 5 && name.find_first_not_of("0123456789") == name.npos;
        const std::size_t number = digits ? static_cast<std::size_t>(std::stoul(name)) : 0;
        if (number == 0 || number >= kMostTools) return "tools/" + name + ": must be a number from 1 to 999";
        if (read.tools.size() <= number) read.tools.resize(number + 1);
        reader.tool(tool, "tools/" + name, read.tools[number]);
      }
    } else if (key == "tool_life") {
      if (std::string wrong = tools::read_life(value, read.tool_life); !wrong.empty()) return wrong;
    } else {
      return key + ": unknown key (external, shift, work, tools, tool_life)";
    }
  }
  if (!reader.mistake().empty()) return reader.mistake();
  into = std::move(read);
  ++into.version;
  return {};
}

std::string load_parameters(const std::string& json_text, MachineData& into) {
  std::string mistake;
  const auto root = parse(json_text, mistake);
  if (!root) return mistake;
  const std::vector<char> no_axes;
  Reader reader(no_axes);
  auto read = into.parameters;
  for (const auto& [key, value] : root->items()) {
    if (value.is_object()) {  // one value an axis: {"1241": {"X": 100}}
      for (const auto& [axis, one] : value.items())
        read[key + "/" + axis] = reader.number(one, key + "/" + axis);
    } else {
      read[key] = value.is_boolean() ? (value.get<bool>() ? 1 : 0) : reader.number(value, key);
    }
  }
  if (!reader.mistake().empty()) return reader.mistake();
  into.parameters = std::move(read);
  ++into.version;
  return {};
}

std::string offsets_to_json(const MachineData& data, const std::vector<char>& axis_names) {
  Json root;
  root["external"] = axis_object(data.work_external, axis_names);
  root["shift"] = axis_object(data.work_shift, axis_names);
  root["work"] = Json::object();
  for (std::size_t i = 0; i < data.work.size(); ++i) {
    root["work"]["G" + std::to_string(54 + i)] = axis_object(data.work[i], axis_names);
  }
  for (std::size_t i = 0; i < data.work_extra.size(); ++i) {
    if (is_zero(data.work_extra[i])) continue;
    root["work"]["G54.1P" + std::to_string(i + 1)] = axis_object(data.work_extra[i], axis_names);
  }
  root["tools"] = Json::object();
  for (std::size_t i = 1; i < data.tools.size(); ++i) {
    const ToolOffset& tool = data.tools[i];
    root["tools"][std::to_string(i)] = {{"geometry", axis_object(tool.geometry, axis_names)},
                                        {"wear", axis_object(tool.wear, axis_names)},
                                        {"radius", tool.radius},
                                        {"radius_wear", tool.radius_wear},
                                        {"tip", tool.tip}};
  }
  if (!data.tool_life.groups.empty()) root["tool_life"] = tools::life_to_json(data.tool_life);
  return root.dump(2);
}

}  // namespace headstock::interp
