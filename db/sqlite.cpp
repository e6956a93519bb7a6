// The only file that knows SQLite.
#include <sqlite3.h>
#include <sys/resource.h>

#include <unordered_map>
#include <utility>

#include "db/database.hpp"

namespace headstock::db {
namespace {

namespace fs = std::filesystem;

/// How long a writer waits for a lock. Only another process could hold one: this one has a single connection.
constexpr int kBusyTimeoutMs = 2'000;

/// Less than this free counts as full: SQLite does not say why a write failed when it was not plainly "no
/// space".
constexpr std::uintmax_t kLittleRoom = 1u << 20;

bool out_of_room(const std::string& file) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) return true;
  std::error_code error;
  const auto space = fs::space(fs::path(file).parent_path(), error);
  return !error && space.available < kLittleRoom;
}

Problem problem_of(int code, const std::string& file) {
  switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return Problem::locked;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return Problem::corrupt;
    case SQLITE_FULL:
      return Problem::disk_full;
    case SQLITE_IOERR:
      return out_of_room(file) ? Problem::disk_full : Problem::unreadable;
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_READONLY:
      return Problem::unreadable;
    case SQLITE_CONSTRAINT:
      return Problem::constraint;
    default:
      return Problem::internal;
  }
}

std::string advice(Problem problem, const std::string& file, const std::string& detail) {
  switch (problem) {
    case Problem::locked:
      return file + ": in use by another server. Stop it, or start this one with another data folder.";
    case Problem::corrupt:
      return file + ": the database is damaged (" + detail +
             "). Nothing was changed. Keep a copy of the data folder, then restore a backup of headstock.db "
             "or "
             "recover it with `sqlite3 headstock.db .recover`.";
    case Problem::disk_full:
      return file +
             ": no room on the disk (or its quota or file size limit is reached); the change was undone. "
             "Free "
             "some space.";
    case Problem::unreadable:
      return file + ": cannot be read or written (" + detail +
             "). Check the permissions of the data folder and the disk.";
    default:
      return file + ": " + detail;
  }
}

class SqliteRow final : public Row {
 public:
  explicit SqliteRow(sqlite3_stmt* statement) : statement_(statement) {}
  bool is_null(int column) const override { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
  std::int64_t integer(int column) const override { return sqlite3_column_int64(statement_, column); }
  double real(int column) const override { return sqlite3_column_double(statement_, column); }
  std::string text(int column) const override {
    const auto* bytes = sqlite3_column_text(statement_, column);
    const auto count = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
    return bytes ? std::string(reinterpret_cast<const char*>(bytes), count) : std::string();
  }
  Value value(int column) const override {
    switch (sqlite3_column_type(statement_, column)) {
      case SQLITE_NULL:
        return {};
      case SQLITE_INTEGER:
        return integer(column);
      case SQLITE_FLOAT:
        return real(column);
      default:
        return text(column);
    }
  }

 private:
  sqlite3_stmt* statement_;
};

class Sqlite final : public Database {
 public:
  explicit Sqlite(const fs::path& file) : file_(file.string()) {
    const int result =
        sqlite3_open_v2(file_.c_str(), &handle_, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
    if (result != SQLITE_OK) {
      const std::string detail = handle_ ? sqlite3_errmsg(handle_) : sqlite3_errstr(result);
      sqlite3_close(handle_);
      throw Error(Problem::unreadable, advice(Problem::unreadable, file_, detail));
    }
    try {
      sqlite3_extended_result_codes(handle_, 1);
      sqlite3_busy_timeout(handle_, kBusyTimeoutMs);
      // One server a database: the lock is taken with the first access and kept until the process ends,
      // however it ends.
      script("PRAGMA locking_mode = EXCLUSIVE");
      demand_sound();
      script(
          "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON;"
          "BEGIN IMMEDIATE; COMMIT");
    } catch (...) {
      close();
      throw;
    }
  }

  ~Sqlite() override { close(); }
  Sqlite(const Sqlite&) = delete;
  Sqlite& operator=(const Sqlite&) = delete;

  void script(const std::string& sql) override {
    if (sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
  }

  bool has_table(std::string_view name) override {
    return integer("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = ?", {name}).has_value();
  }
  std::string place() const override { return file_; }

  std::vector<TableShape> tables() override {
    std::vector<TableShape> found;
    // In the order in which they were made: a table refers only to older ones.
    each("SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite%' ORDER BY rowid", {},
         [&](const Row& row) { found.push_back({row.text(0), {}}); });
    for (TableShape& table : found)
      each("SELECT name FROM pragma_table_info(?) ORDER BY cid", {table.name},
           [&](const Row& row) { table.columns.push_back(row.text(0)); });
    return found;
  }

  std::unique_ptr<Snapshot> snapshot(const fs::path& folder) override;
  /// AUTOINCREMENT follows by itself.
  void follow_ids() override {}

  void set_guard(const std::string& table, const std::string& trigger, Guard guard) override {
    if (guard == Guard::open) {
      const auto sql = text("SELECT sql FROM sqlite_master WHERE type = 'trigger' AND name = ? AND tbl_name = ?", {trigger, table});
      if (!sql) throw Error(Problem::internal, "there is no trigger " + trigger);
      open_guards_[trigger] = *sql;
      script("DROP TRIGGER " + trigger);
    } else {
      script(open_guards_.at(trigger));
      open_guards_.erase(trigger);
    }
  }

 protected:
  std::int64_t run(std::string_view sql, const Values& values, const RowHandler& row) override {
    if (depth() > 0 && sqlite3_get_autocommit(handle_) != 0)
      throw Error(Problem::disk_full, file_ + ": the transaction was undone by an earlier error");
    Borrowed borrowed(*this, sql);
    sqlite3_stmt* statement = borrowed.statement;
    for (std::size_t i = 0; i < values.size(); ++i) bind(statement, static_cast<int>(i) + 1, values[i]);
    const SqliteRow view(statement);
    for (;;) {
      const int result = sqlite3_step(statement);
      if (result == SQLITE_DONE) break;
      if (result != SQLITE_ROW) fail();
      if (row) row(view);
    }
    return sqlite3_changes64(handle_);
  }

 private:
  void close() {
    for (auto& [sql, statement] : idle_) sqlite3_finalize(statement);
    idle_.clear();
    sqlite3_close(handle_);
    handle_ = nullptr;
  }

  /// A prepared statement taken from the idle ones and given back; the same text may be in use twice.
  struct Borrowed {
    Borrowed(Sqlite& owner, std::string_view text) : home(owner) {
      const auto found = home.idle_.find(std::string(text));
      if (found != home.idle_.end()) {
        sql = found->first;
        statement = found->second;
        home.idle_.erase(found);
        return;
      }
      sql = text;
      if (sqlite3_prepare_v3(home.handle_, sql.data(), static_cast<int>(sql.size()),
                             SQLITE_PREPARE_PERSISTENT, &statement, nullptr) != SQLITE_OK)
        home.fail();
    }
    ~Borrowed() {
      sqlite3_reset(statement);
      sqlite3_clear_bindings(statement);
      if (home.idle_.size() < 256 && home.idle_.emplace(sql, statement).second) return;
      sqlite3_finalize(statement);
    }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;
    Sqlite& home;
    std::string sql;
    sqlite3_stmt* statement = nullptr;
  };

  void bind(sqlite3_stmt* statement, int index, const Value& value) {
    struct Visitor {
      sqlite3_stmt* statement;
      int index;
      int operator()(std::nullptr_t) const { return sqlite3_bind_null(statement, index); }
      int operator()(std::int64_t number) const { return sqlite3_bind_int64(statement, index, number); }
      int operator()(double number) const { return sqlite3_bind_double(statement, index, number); }
      int operator()(const std::string& text) const {
        return sqlite3_bind_text64(statement, index, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
      }
    };
    if (std::visit(Visitor{statement, index}, value.storage()) != SQLITE_OK) fail();
  }

  void demand_sound() {
    std::string first;
    try {
      each("PRAGMA quick_check(1)", {}, [&](const Row& row) {
        if (first.empty()) first = row.text(0);
      });
    } catch (const Error& error) {
      if (error.problem() == Problem::internal)
        throw Error(Problem::corrupt, advice(Problem::corrupt, file_, error.what()));
      throw;
    }
    if (first != "ok") throw Error(Problem::corrupt, advice(Problem::corrupt, file_, first));
  }

  [[noreturn]] void fail() {
    const Problem problem = problem_of(sqlite3_extended_errcode(handle_), file_);
    throw Error(problem, advice(problem, file_, sqlite3_errmsg(handle_)));
  }

  std::string file_;
  sqlite3* handle_ = nullptr;
  std::unordered_map<std::string, std::string> open_guards_;  ///< what makes them again
  std::unordered_map<std::string, sqlite3_stmt*> idle_;
};

/// SQLite's online backup: copies pages between other statements of the same connection, whose changes it follows.
class SqliteSnapshot final : public Snapshot {
 public:
  SqliteSnapshot(sqlite3* from, fs::path file) : from_(from), file_(std::move(file)) {
    std::error_code ignored;
    fs::remove(file_, ignored);
    if (sqlite3_open(file_.c_str(), &to_) != SQLITE_OK) fail();
    backup_ = sqlite3_backup_init(to_, "main", from_, "main");
    if (!backup_) fail();
  }
  ~SqliteSnapshot() override {
    close();
    std::error_code ignored;
    for (const char* tail : {"", "-wal", "-shm", "-journal"}) fs::remove(file_.string() + tail, ignored);
  }
  SqliteSnapshot(const SqliteSnapshot&) = delete;
  SqliteSnapshot& operator=(const SqliteSnapshot&) = delete;

  bool step() override {
    if (!backup_) return false;
    const int result = sqlite3_backup_step(backup_, kPagesAStep);
    if (result == SQLITE_OK || result == SQLITE_BUSY || result == SQLITE_LOCKED) return true;
    if (result != SQLITE_DONE) fail();
    close();
    return false;
  }
  std::unique_ptr<Database> open() override { return open_sqlite(file_); }

 private:
  static constexpr int kPagesAStep = 256;  ///< 1 MiB

  void close() {
    if (backup_) sqlite3_backup_finish(std::exchange(backup_, nullptr));
    sqlite3_close(std::exchange(to_, nullptr));
  }
  [[noreturn]] void fail() {
    const Problem problem = problem_of(sqlite3_extended_errcode(to_), file_.string());
    const std::string text = advice(problem, file_.string(), sqlite3_errmsg(to_));
    close();
    throw Error(problem, text);
  }

  sqlite3* from_;
  fs::path file_;
  sqlite3* to_ = nullptr;
  sqlite3_backup* backup_ = nullptr;
};

std::unique_ptr<Snapshot> Sqlite::snapshot(const fs::path& folder) {
  return std::make_unique<SqliteSnapshot>(handle_, folder / "snapshot.db");
}

}  // namespace

std::unique_ptr<Database> open_sqlite(const fs::path& file) {
  return std::make_unique<Sqlite>(file);
}

}  // namespace headstock::db
