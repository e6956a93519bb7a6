// The few SQLite calls the spool needs, with errors as exceptions and handles that close themselves. Private
// to link/.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "link/spool.hpp"

namespace headstock::link::sqlite {

/// Turns an error of SQLite into what a person at the machine can act on.
[[noreturn]] void fail(sqlite3* db, const std::string& file, const char* doing);

class Connection {
 public:
  Connection() = default;
  ~Connection() { sqlite3_close(db_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void open(const std::string& file);
  void run(const char* sql);
  sqlite3* get() const { return db_; }
  const std::string& file() const { return file_; }

 private:
  sqlite3* db_ = nullptr;
  std::string file_;
};

class Statement {
 public:
  Statement(const Connection& connection, const char* sql);
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(int index, std::int64_t value);
  Statement& bind(int index, std::string_view text);
  /// @return true when there is a row.
  bool step();
  void reset();
  std::int64_t integer(int column) const { return sqlite3_column_int64(statement_, column); }
  std::string text(int column) const;

 private:
  const Connection& connection_;
  sqlite3_stmt* statement_ = nullptr;
};

}  // namespace headstock::link::sqlite
