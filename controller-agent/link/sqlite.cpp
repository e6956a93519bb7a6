#include "link/sqlite.hpp"

namespace headstock::link::sqlite {

void fail(sqlite3* db, const std::string& file, const char* doing) {
  const int code = db ? sqlite3_errcode(db) & 0xff : SQLITE_NOMEM;
  const std::string detail = db ? sqlite3_errmsg(db) : "out of memory";
  const std::string head = file + ": " + doing + ": " + detail;
  switch (code) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      throw SpoolDamaged(
          head + ". The spool of events is damaged; nothing was changed. Set the file aside and start again");
    case SQLITE_FULL:
      throw SpoolError(head + ". The disk is full: free some space; nothing of this was written");
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      throw SpoolError(head +
                       ". Another process uses the spool: is a second agent running on this data folder?");
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_READONLY:
      throw SpoolError(head + ". Check that the folder exists and that this user may write in it");
    default:
      throw SpoolError(head);
  }
}

void Connection::open(const std::string& file) {
  file_ = file;
  constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  if (sqlite3_open_v2(file.c_str(), &db_, kFlags, nullptr) != SQLITE_OK) fail(db_, file, "cannot be opened");
  sqlite3_extended_result_codes(db_, 0);
}

void Connection::run(const char* sql) {
  if (sqlite3_exec(db_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail(db_, file_, "cannot be written");
}

Statement::Statement(const Connection& connection, const char* sql) : connection_(connection) {
  if (sqlite3_prepare_v2(connection.get(), sql, -1, &statement_, nullptr) != SQLITE_OK)
    fail(connection.get(), connection.file(), "cannot be read");
}

Statement& Statement::bind(int index, std::int64_t value) {
  sqlite3_bind_int64(statement_, index, value);
  return *this;
}

Statement& Statement::bind(int index, std::string_view text) {
  // Copied by SQLite (-1 as destructor is SQLITE_TRANSIENT, whose C cast does not pass our warnings).
  sqlite3_bind_text64(statement_, index, text.data(), text.size(),
                      reinterpret_cast<sqlite3_destructor_type>(-1), SQLITE_UTF8);
  return *this;
}

bool Statement::step() {
  const int result = sqlite3_step(statement_);
  if (result == SQLITE_ROW) return true;
  if (result == SQLITE_DONE) return false;
  fail(connection_.get(), connection_.file(), "cannot be used");
}

void Statement::reset() {
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
}

std::string Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return bytes ? std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)))
               : std::string();
}

}  // namespace headstock::link::sqlite
