#include "server/fleet/value_sheet.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>

#include "db/refusal.hpp"
#include "interpreter/data_values.hpp"

namespace headstock::fleet {
namespace {

constexpr std::size_t kMostBytes = 4u << 20;

std::string trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '"')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '"' || text.back() == '\r'))
    text.remove_suffix(1);
  return std::string(text);
}

std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells;
  while (true) {
    const std::size_t end = line.find(separator);
    cells.push_back(trimmed(line.substr(0, end)));
    if (end == line.npos) return cells;
    line.remove_prefix(end + 1);
  }
}

std::string lower(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// What the heads of columns may be called: the field of a tool, with "length" for the axis of a mill's
/// length.
const std::map<std::string, std::string, std::less<>>& heads() {
  static const std::map<std::string, std::string, std::less<>> table = {{"r", "radius"},
                                                                        {"radius", "radius"},
                                                                        {"半径", "radius"},
                                                                        {"刀尖半径", "radius"},
                                                                        {"r wear", "radius_wear"},
                                                                        {"radius wear", "radius_wear"},
                                                                        {"半径磨损", "radius_wear"},
                                                                        {"r磨损", "radius_wear"},
                                                                        {"tip", "tip"},
                                                                        {"t", "tip"},
                                                                        {"刀尖", "tip"},
                                                                        {"刀尖号", "tip"},
                                                                        {"length", "geometry/Z"},
                                                                        {"长度", "geometry/Z"},
                                                                        {"length wear", "wear/Z"},
                                                                        {"长度磨损", "wear/Z"}};
  return table;
}

/// A head as the tail of a value's name; empty: unknown.
std::string tool_field(const std::string& head, const std::vector<char>& axes) {
  const std::string small = lower(head);
  if (const auto found = heads().find(small); found != heads().end()) return found->second;
  for (const char axis : axes) {
    const std::string letter(1, static_cast<char>(std::tolower(static_cast<unsigned char>(axis))));
    if (small == letter || small == letter + " geometry" || small == letter + "形状")
      return std::string("geometry/") + axis;
    if (small == letter + " wear" || small == letter + "磨损") return std::string("wear/") + axis;
  }
  return {};
}

/// @return false: no number.
bool read_number(std::string text, bool decimal_comma, std::optional<double>& value) {
  if (decimal_comma) std::ranges::replace(text, ',', '.');
  if (text.starts_with("\xE2\x88\x92")) text.replace(0, 3, "-");  // the minus sign of word processors
  if (text.starts_with('+')) text.erase(0, 1);
  double read = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), read);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(read)) return false;
  value = read;
  return true;
}

void hold_against_machine(const std::string& line, const MachinePages& pages) {
  const auto said = [&line](std::string_view name) -> std::string {
    const std::size_t at = line.find(name);
    if (at == line.npos) return {};
    const std::size_t end = line.find(';', at);
    return trimmed(
        std::string_view(line).substr(at + name.size(), end == line.npos ? end : end - at - name.size()));
  };
  const std::string profile = said("profile "), unit = said("unit ");
  if (!profile.empty() && profile != pages.machine.profile)
    throw db::Refusal("other_profile", profile.substr(0, 60));
  if (!unit.empty() && unit != "mm") throw db::Refusal("other_unit", unit.substr(0, 20));
}

/// The columns after the first: tails of names; the first cell of a row completes them.
struct Table {
  enum class First { number, system, what } first = First::what;
  std::vector<std::string> fields;
};

Table table_of(const std::vector<std::string>& cells, const MachinePages& pages, std::int64_t line) {
  static constexpr std::array<std::string_view, 7> kNumber = {"number", "no",     "no.", "offset",
                                                              "序号",   "刀补号", "番号"};
  static constexpr std::array<std::string_view, 4> kSystem = {"system", "work", "坐标系", "工件坐标系"};
  static constexpr std::array<std::string_view, 3> kWhat = {"what", "name", "名称"};
  const std::string first = lower(cells[0]);
  Table table;
  if (std::ranges::find(kNumber, first) != kNumber.end()) {
    table.first = Table::First::number;
    for (std::size_t i = 1; i < cells.size(); ++i) {
      table.fields.push_back(tool_field(cells[i], pages.axes));
      if (table.fields.back().empty() && !cells[i].empty())
        throw db::Refusal("bad_sheet", std::to_string(line) + ": " + cells[i].substr(0, 40));
    }
  } else if (std::ranges::find(kSystem, first) != kSystem.end()) {
    table.first = Table::First::system;
    for (std::size_t i = 1; i < cells.size(); ++i) {
      const bool axis =
          cells[i].size() == 1 && std::ranges::find(pages.axes, cells[i][0]) != pages.axes.end();
      if (!axis) throw db::Refusal("bad_sheet", std::to_string(line) + ": " + cells[i].substr(0, 40));
      table.fields.push_back(cells[i]);
    }
  } else if (std::ranges::find(kWhat, first) != kWhat.end() && cells.size() >= 2) {
    table.first = Table::First::what;
    table.fields = {""};
  } else {
    throw db::Refusal("bad_sheet", std::to_string(line) + ": " + cells[0].substr(0, 40));
  }
  return table;
}

std::string name_of(const Table& table, const std::string& first, const std::string& field) {
  if (table.first == Table::First::what) return first;
  if (table.first == Table::First::system) return "work/" + first + "/" + field;
  // "T03", "03", "3"
  std::string_view digits = first;
  if (!digits.empty() && (digits[0] == 'T' || digits[0] == 't')) digits.remove_prefix(1);
  while (digits.size() > 1 && digits[0] == '0') digits.remove_prefix(1);
  return "tool/" + std::string(digits) + "/" + field;
}

/// Shortest text that is read back as the same number.
std::string shortest(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value == 0 ? 0.0 : value).ptr;
  return {text, end};
}

std::vector<std::pair<std::string, std::string>> tool_columns(const MachinePages& pages) {
  std::vector<std::pair<std::string, std::string>> columns;  // head, field
  const auto add = [&](const std::string& head, const std::string& geometry, const std::string& wear) {
    columns.emplace_back(head, geometry);
    if (pages.page.wear) columns.emplace_back(head + " wear", wear);
  };
  if (pages.page.lathe) {
    for (const char axis : pages.axes) {
      const std::string name(1, axis);
      add(name, "geometry/" + name, "wear/" + name);
    }
    add("R", "radius", "radius_wear");
    columns.emplace_back("tip", "tip");
  } else {
    add("length", "geometry/Z", "wear/Z");
    if (pages.page.memory == 'C') add("radius", "radius", "radius_wear");
  }
  return columns;
}

}  // namespace

Sheet read_sheet(const MachinePages& pages, const std::string& text) {
  if (text.size() > kMostBytes) throw db::Refusal("too_large", "table");
  Sheet sheet;
  std::optional<Table> table;
  char separator = 0;
  std::int64_t line_number = 0;
  interp::MachineData data = pages.data;
  std::string_view left = text;
  if (left.starts_with("\xEF\xBB\xBF")) left.remove_prefix(3);
  while (!left.empty()) {
    const std::size_t end = left.find('\n');
    const std::string line = [&] {
      std::string cut(left.substr(0, end));
      if (cut.ends_with('\r')) cut.pop_back();
      return cut;
    }();
    left.remove_prefix(end == left.npos ? left.size() : end + 1);
    ++line_number;
    if (trimmed(line).empty()) continue;
    if (line.starts_with('#')) {
      hold_against_machine(line, pages);
      continue;
    }
    if (separator == 0)
      separator = line.find('\t') != line.npos ? '\t' : line.find(';') != line.npos ? ';' : ',';
    const std::vector<std::string> cells = cells_of(line, separator);
    if (!table) {
      table = table_of(cells, pages, line_number);
      continue;
    }
    for (std::size_t i = 0; i < table->fields.size() && i + 1 < cells.size(); ++i) {
      const std::string& cell = cells[i + 1];
      if (cell.empty()) continue;
      ++sheet.values;
      SheetRow row;
      row.line = line_number;
      row.item.what = name_of(*table, cells[0], table->fields[i]).substr(0, 80);
      row.text = cell.substr(0, 40);
      const interp::ValueRead now = interp::read_value(pages.data, pages.axes, row.item.what);
      row.item.before = now.value;
      if (!now.known) {
        row.problem = "bad_place";
      } else if (!read_number(cell, separator != ',', row.item.after)) {
        row.problem = "not_a_number";
      } else {
        row.problem =
            dialects::refuse_value(*pages.dialect, data, pages.axes, row.item.what, row.item.after, kAnyTime);
        if (row.problem.empty() &&
            !interp::write_value(data, pages.axes, row.item.what, row.item.after, pages.page.numbers))
          row.problem = "out_of_range";
      }
      const bool differs = !same_as_shown(now.value, row.item.after);
      if (!row.problem.empty() || differs) sheet.rows.push_back(std::move(row));
    }
  }
  if (!table) throw db::Refusal("bad_sheet", "1");
  return sheet;
}

std::string write_sheet(const MachinePages& pages, const db::MachineValues& values, const std::string& kind) {
  const auto value = [&](const std::string& what) {
    const auto found = values.find(what);
    return shortest(found != values.end() ? found->second : 0);
  };
  std::string out =
      "# Headstock; profile " + pages.machine.profile + "; unit mm; machine " + pages.machine.name + "\n";
  if (kind == "offsets") {
    const auto columns = tool_columns(pages);
    out += "number";
    for (const auto& [head, field] : columns) out += "," + head;
    out += "\n";
    for (std::size_t number_ = 1; number_ <= pages.page.numbers; ++number_) {
      out += std::to_string(number_);
      for (const auto& [head, field] : columns)
        out += "," + value("tool/" + std::to_string(number_) + "/" + field);
      out += "\n";
    }
    return out;
  }
  if (kind == "work") {
    std::vector<std::string> systems = {"EXT"};
    if (pages.page.lathe) systems.emplace_back("shift");
    for (int i = 0; i < pages.page.work_systems; ++i) systems.push_back("G" + std::to_string(54 + i));
    for (int i = 1; i <= pages.page.extra_systems; ++i) systems.push_back("G54.1P" + std::to_string(i));
    out += "system";
    for (const char axis : pages.axes) out += std::string(",") + axis;
    out += "\n";
    for (const std::string& system : systems) {
      out += system;
      for (const char axis : pages.axes) out += "," + value("work/" + system + "/" + axis);
      out += "\n";
    }
    return out;
  }
  out += "what,value\n";
  for (const auto& [what, number_] : values)
    if (in_kind(kind, what)) out += what + "," + shortest(number_) + "\n";
  return out;
}

}  // namespace headstock::fleet
