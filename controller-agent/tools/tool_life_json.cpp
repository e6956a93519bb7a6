#include "tools/tool_life_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace headstock::tools {
namespace {

using Json = nlohmann::json;

constexpr double kMost = 1e9;

struct Mistake : std::runtime_error {
  using std::runtime_error::runtime_error;
};

double number(const Json& value, const std::string& where) {
  if (!value.is_number() || !(value.get<double>() >= 0) || value.get<double>() > kMost)
    throw Mistake(where + ": must be a number from 0");
  return value.get<double>();
}

std::int32_t whole(const Json& value, const std::string& where) {
  const double read = number(value, where);
  if (read != std::floor(read)) throw Mistake(where + ": must be a whole number");
  return static_cast<std::int32_t>(read);
}

// Seconds in the file, tenths inside.
std::int64_t amount(const Json& value, LifeUnit unit, const std::string& where) {
  return unit == LifeUnit::uses ? whole(value, where) : std::llround(number(value, where) * 10);
}

Json amount_to_json(std::int64_t value, LifeUnit unit) {
  if (unit == LifeUnit::uses) return value;
  return static_cast<double>(value) / 10;
}

LifeTool read_tool(const Json& object, LifeUnit unit, const std::string& where) {
  if (!object.is_object()) throw Mistake(where + ": must be an object");
  LifeTool tool;
  for (const auto& [key, value] : object.items()) {
    const std::string place = where + "/" + key;
    if (key == "tool") {
      tool.tool = whole(value, place);
    } else if (key == "offset") {
      tool.offset = whole(value, place);
    } else if (key == "h") {
      tool.h = whole(value, place);
    } else if (key == "d") {
      tool.d = whole(value, place);
    } else if (key == "used") {
      tool.used = amount(value, unit, place);
    } else if (key == "skipped") {
      if (!value.is_boolean()) throw Mistake(place + ": must be true or false");
      tool.skipped = value.get<bool>();
    } else {
      throw Mistake(place + ": unknown key");
    }
  }
  return tool;
}

LifeGroup read_group(const Json& object, const std::string& where) {
  if (!object.is_object()) throw Mistake(where + ": must be an object");
  LifeGroup group;
  if (const auto unit = object.find("unit"); unit != object.end()) {
    if (*unit != "uses" && *unit != "seconds") throw Mistake(where + "/unit: must be uses or seconds");
    group.unit = *unit == "uses" ? LifeUnit::uses : LifeUnit::tenths;
  }
  for (const auto& [key, value] : object.items()) {
    const std::string place = where + "/" + key;
    if (key == "life") {
      group.life = amount(value, group.unit, place);
    } else if (key == "current") {
      group.current = static_cast<std::size_t>(whole(value, place));
    } else if (key == "tools") {
      if (!value.is_array()) throw Mistake(place + ": must be an array");
      for (const Json& tool : value)
        group.tools.push_back(read_tool(tool, group.unit, place + "/" + std::to_string(group.tools.size())));
    } else if (key != "unit") {
      throw Mistake(place + ": unknown key");
    }
  }
  if (group.life <= 0) throw Mistake(where + "/life: must be more than 0");
  if (group.current != 0 && group.current >= group.tools.size())
    throw Mistake(where + "/current: the group has no such tool");
  return group;
}

}  // namespace

std::string read_life(const Json& object, LifeTable& into) {
  try {
    if (!object.is_object()) throw Mistake("tool_life: must be an object of group numbers");
    LifeTable read;
    for (const auto& [key, value] : object.items()) {
      const std::string where = "tool_life/" + key;
      if (key.empty() || key.size() > 4 || key.find_first_not_of("0123456789") != key.npos ||
          std::stoi(key) == 0)
        throw Mistake(where + ": must be a group number");
      read.groups.emplace(std::stoi(key), read_group(value, where));
    }
    into = std::move(read);
    return {};
  } catch (const Mistake& mistake) {
    return mistake.what();
  }
}

Json life_to_json(const LifeTable& table) {
  Json out = Json::object();
  for (const auto& [number, group] : table.groups) {
    Json tools = Json::array();
    for (const LifeTool& tool : group.tools) {
      Json one = {{"tool", tool.tool}, {"used", amount_to_json(tool.used, group.unit)}};
      if (tool.offset != 0) one["offset"] = tool.offset;
      if (tool.h != 0) one["h"] = tool.h;
      if (tool.d != 0) one["d"] = tool.d;
      if (tool.skipped) one["skipped"] = true;
      tools.push_back(std::move(one));
    }
    out[std::to_string(number)] = {{"unit", group.unit == LifeUnit::uses ? "uses" : "seconds"},
                                   {"life", amount_to_json(group.life, group.unit)},
                                   {"current", group.current},
                                   {"tools", std::move(tools)}};
  }
  return out;
}

}  // namespace headstock::tools
