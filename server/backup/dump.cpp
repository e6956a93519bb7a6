#include "server/backup/dump.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "db/hash.hpp"
#include "db/refusal.hpp"

namespace headstock::backup {
namespace {

using nlohmann::json;

constexpr std::size_t kPieceBytes = 4u << 20;

/// Texts that are no UTF-8 go as hexadecimal: not a bit may change.
json to_json(const db::Value& value) {
  struct Visitor {
    json operator()(std::nullptr_t) const { return nullptr; }
    json operator()(std::int64_t number) const { return number; }
    json operator()(double number) const { return number; }
    json operator()(const std::string& text) const {
      try {
        json plain = text;
        plain.dump();
        return plain;
      } catch (const json::exception&) {
        return {{"hex", db::to_hex(text)}};
      }
    }
  };
  return std::visit(Visitor{}, value.storage());
}

db::Value from_json(const json& value, const std::string& where) {
  if (value.is_null()) return {};
  if (value.is_number_integer()) return value.get<std::int64_t>();
  if (value.is_number()) return value.get<double>();
  if (value.is_string()) return value.get<std::string>();
  const auto hex = value.is_object() ? value.find("hex") : value.end();
  if (hex == value.end() || !hex->is_string()) throw db::Refusal("damaged_backup", where);
  const auto digits = hex->get<std::string>();
  std::string bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
    bytes += static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16));
  return bytes;
}

std::string identifier(const std::string& name) {
  return "\"" + name + "\"";
}

std::string joined(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + identifier(name);
  return all;
}

std::string piece_name(const std::string& table, int number) {
  std::array<char, 16> digits{};
  std::snprintf(digits.data(), digits.size(), "%06d", number);
  return "tables/" + table + "/" + digits.data() + ".jsonl";
}

}  // namespace

bool is_kept(const std::string& table) {
  static constexpr std::string_view kLeftOut[] = {"schema_migrations", "sessions", "sign_in_failures"};
  return std::ranges::find(kLeftOut, table) == std::end(kLeftOut);
}

void dump(db::Database& db, const std::function<void(const std::string&, const std::string&)>& piece) {
  for (const db::TableShape& table : db.tables()) {
    if (!is_kept(table.name)) continue;
    const std::string head = json(table.columns).dump() + "\n";
    std::string text = head;
    int number = 1;
    const auto give = [&] {
      piece(piece_name(table.name, number++), text);
      text = head;
    };
    db.each("SELECT " + joined(table.columns) + " FROM " + identifier(table.name), {}, [&](const db::Row& row) {
      json values = json::array();
      for (int column = 0; column < static_cast<int>(table.columns.size()); ++column)
        values.push_back(to_json(row.value(column)));
      text += values.dump();
      text += '\n';
      if (text.size() >= kPieceBytes) give();
    });
    if (number == 1 || text.size() > head.size()) give();
  }
}

Loader::Loader(db::Database& db) : db_(db), tables_(db.tables()) {
  for (auto table = tables_.rbegin(); table != tables_.rend(); ++table)
    if (is_kept(table->name)) db.execute("DELETE FROM " + identifier(table->name));
}

void Loader::piece(const std::string& name, const std::string& text) {
  // tables/NAME/…
  const auto end = name.find('/', 7);
  const std::string table_name = end == std::string::npos ? "" : name.substr(7, end - 7);
  const auto table = std::ranges::find(tables_, table_name, &db::TableShape::name);
  if (table == tables_.end() || !is_kept(table_name)) throw db::Refusal("newer_backup", table_name);
  std::istringstream lines(text);
  std::string line;
  std::getline(lines, line);
  const json head = json::parse(line, nullptr, false);
  if (!head.is_array() || head.empty()) throw db::Refusal("damaged_backup", name);
  const auto columns = head.get<std::vector<std::string>>();
  for (const std::string& column : columns)
    if (std::ranges::find(table->columns, column) == table->columns.end())
      throw db::Refusal("newer_backup", table_name + "." + column);
  std::string marks;
  for (std::size_t i = 0; i < columns.size(); ++i) marks += i == 0 ? "?" : ", ?";
  const std::string sql = "INSERT INTO " + identifier(table_name) + " (" + joined(columns) + ") VALUES (" + marks + ")";
  while (std::getline(lines, line)) {
    const json row = json::parse(line, nullptr, false);
    if (!row.is_array() || row.size() != columns.size()) throw db::Refusal("damaged_backup", name);
    db::Values values;
    for (const json& value : row) values.push_back(from_json(value, name));
    db_.execute(sql, values);
    ++rows_;
  }
}

}  // namespace headstock::backup
