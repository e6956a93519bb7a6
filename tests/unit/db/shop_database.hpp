// A database in a folder that vanishes with the test.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "db/database.hpp"
#include "db/hash.hpp"
#include "db/migrations.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace headstock::test {

using testing_support::TemporaryFolder;

/// Empty: SQLite. Otherwise (tests/with-postgresql sets HEADSTOCK_TEST_DATABASE) a new empty PostgreSQL database, so
/// that the same tests run on both.
/// @param model the database to copy; empty: an empty one.
inline std::string test_database(const std::string& model = {}) {
  const char* const server = std::getenv("HEADSTOCK_TEST_DATABASE");
  if (!server) return {};
  const std::string name = "shop_" + db::random_hex(6);
  // Not open_postgres: that would hold the database which the others are made from.
  const std::string copy = model.empty() ? model : "-T " + model + " ";
  const std::string command = std::string("createdb --maintenance-db='") + server + "' " + copy + name;
  if (std::system(command.c_str()) != 0) throw std::runtime_error("cannot make a test database: " + command);
  return std::string(server) + "&dbname=" + name;
}

/// The name of an empty shop's database, made once: copying it is ten times faster than all migrations.
inline const std::string& model_shop() {
  static const std::string name = [] {
    const std::string connection = test_database();
    db::migrate(*db::open_postgres(connection));
    return connection.substr(connection.rfind('=') + 1);
  }();
  return name;
}

inline std::unique_ptr<db::Database> open_shop(const std::filesystem::path& file) {
  const std::string connection = std::getenv("HEADSTOCK_TEST_DATABASE") ? test_database(model_shop()) : std::string();
  auto database = connection.empty() ? db::open_sqlite(file) : db::open_postgres(connection);
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
