// A database in a folder that vanishes with the test.
#pragma once

#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>

#include "db/database.hpp"
#include "db/migrations.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace headstock::test {

using testing_support::TemporaryFolder;

inline std::unique_ptr<db::Database> open_shop(const std::filesystem::path& file) {
  auto database = db::open_sqlite(file);
  db::migrate(*database);
  return database;
}

/// Texts put together by append: GCC 12 warns falsely about operator+ with short literals.
inline std::string text_of(std::initializer_list<std::string_view> pieces) {
  std::string text;
  for (const std::string_view piece : pieces) text.append(piece);
  return text;
}

inline std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace headstock::test
