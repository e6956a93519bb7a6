// Build tool: turns a tab-separated table into a C++ constant (see EmbedTable.cmake).
// Usage: embed_table FILE NAME OUT_FOLDER COLUMN…
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace {

std::vector<std::string> cells_of(std::string_view line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == '\t')
      cells.emplace_back();
    else
      cells.back().push_back(c);
  }
  return cells;
}

std::string literal(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"sv";
}

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out << text;
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

void embed(const std::string& file, const std::string& name, const std::filesystem::path& folder,
           const std::vector<std::string>& columns) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file + ": cannot be read");
  const auto fail = [&](std::size_t line, const std::string& what) {
    throw std::runtime_error(file + ":" + std::to_string(line) + ": " + what);
  };

  std::string line;
  std::size_t number = 0;
  std::size_t count = 0;
  std::ostringstream rows;
  while (std::getline(in, line)) {
    ++number;
    if (line.find('\r') != std::string::npos) fail(number, "carriage return in the line");
    const auto cells = cells_of(line);
    if (number == 1) {
      if (cells != columns) fail(1, "the columns are not those that the build expects");
      continue;
    }
    if (cells.size() != columns.size())
      fail(number, std::to_string(cells.size()) + " cells instead of " + std::to_string(columns.size()));
    rows << "    Row{";
    for (const auto& cell : cells) rows << literal(cell) << ", ";
    rows << "},\n";
    ++count;
  }
  if (count == 0) fail(number, "no rows");

  const std::string row = "std::array<std::string_view, " + std::to_string(columns.size()) + ">";
  std::string comment;
  for (const auto& column : columns) comment += " | " + column;
  std::filesystem::create_directories(folder);
  write_file(folder / (name + ".hpp"),
             "#pragma once\n#include <array>\n#include <span>\n#include <string_view>\n\n"
             "namespace headstock::tables {\n// Columns:" +
                 comment +
                 "\n"
                 "extern const std::span<const " +
                 row + "> " + name + ";\n}\n");
  write_file(folder / (name + ".cpp"), "#include \"" + name +
                                           ".hpp\"\n\nnamespace headstock::tables {\n"
                                           "using namespace std::string_view_literals;\nnamespace " + name + "_table {\n"
                                           "using Row = " +
                                           row + ";\nconstexpr std::array<Row, " + std::to_string(count) +
                                           "> rows{\n" + rows.str() +
                                           "};\n}\n"
                                           "constinit const std::span<const " + name + "_table::Row> " +
                                           name + "{" + name + "_table::rows};\n}\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::cerr << "usage: embed_table FILE NAME OUT_FOLDER COLUMN...\n";
    return 1;
  }
  try {
    embed(argv[1], argv[2], argv[3], {argv + 4, argv + argc});
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
