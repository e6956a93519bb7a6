// One connection to the shop's database, and transactions on it. The stores speak only this interface and SQL
// that SQLite and PostgreSQL both understand ("?" parameters, RETURNING, ON CONFLICT). One thread at a time:
// see store.hpp.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "db/value.hpp"

namespace headstock::db {

/// What went wrong, for the one who must decide what to tell.
enum class Problem {
  locked,      ///< another server holds the database
  corrupt,     ///< the file is damaged; nothing was changed
  newer,       ///< made by a newer Headstock than this one
  tampered,    ///< an already applied migration differs from the one built in
  disk_full,   ///< no room (or quota, or file size limit); the change was rolled back
  unreadable,  ///< cannot be opened: permissions, a folder, read-only
  constraint,  ///< a rule of the schema was broken (unique, foreign key, immutable row)
  lost,        ///< the connection to the database server broke; the change was undone or its end is not known
  internal     ///< a mistake of ours
};

/// Thrown by everything in db/. `what()` is one line for a person and says what to do.
class Error : public std::runtime_error {
 public:
  Error(Problem problem, const std::string& text) : std::runtime_error(text), problem_(problem) {}
  Problem problem() const { return problem_; }

 private:
  Problem problem_;
};

using RowHandler = std::function<void(const Row&)>;

class Database;

/// The whole database as it was at one moment, taken while it is in use.
class Snapshot {
 public:
  virtual ~Snapshot() = default;
  /// On the database's own thread, again and again until false: a piece of the copying, a few milliseconds each.
  virtual bool step() = 0;
  /// Then, on any thread: the copy, for reading only.
  virtual std::unique_ptr<Database> open() = 0;
};

enum class Guard { open, closed };

struct TableShape {
  std::string name;
  std::vector<std::string> columns;
};


class Database {
 public:
  virtual ~Database() = default;

  /// Runs one statement. @return number of rows it changed.
  std::int64_t execute(std::string_view sql, const Values& values = {}) { return run(sql, values, nullptr); }
  /// Runs a query and hands over each row. The handler must not use the database.
  void each(std::string_view sql, const Values& values, const RowHandler& row) { run(sql, values, row); }
  /// First column of the first row, or nothing. Also for INSERT … RETURNING id.
  std::optional<std::int64_t> integer(std::string_view sql, const Values& values = {});
  std::optional<std::string> text(std::string_view sql, const Values& values = {});
  /// Runs several statements separated by semicolons (migrations).
  virtual void script(const std::string& sql) = 0;
  virtual bool has_table(std::string_view name) = 0;
  /// Every table of the shop, those first that others refer to; without the engine's own.
  virtual std::vector<TableShape> tables() = 0;
  /// @param folder where a copy may be kept meanwhile.
  virtual std::unique_ptr<Snapshot> snapshot(const std::filesystem::path& folder) = 0;
  /// After rows were put in with their ids: the next id is above them.
  virtual void follow_ids() = 0;
  /// Opens and closes a trigger of the migrations that keeps history, inside a transaction: for the retention alone.
  virtual void set_guard(const std::string& table, const std::string& trigger, Guard guard) = 0;
  /// Where it is, for people: a file, or a server's address without a password.
  virtual std::string place() const = 0;

 protected:
  virtual std::int64_t run(std::string_view sql, const Values& values, const RowHandler& row) = 0;
  /// Transactions open; when the engine itself undoes one (disk full), nothing may run until this is 0 again.
  int depth() const { return depth_; }

 private:
  friend class Transaction;
  int depth_ = 0;
};

/// All or nothing. Inside another one it is a savepoint of it, so that services compose. Without commit()
/// everything done since is undone when it goes out of scope.
class Transaction {
 public:
  explicit Transaction(Database& database);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  Database& database_;
  int depth_;
  bool open_ = true;
};

/// Opens DATA/headstock.db (made if absent): write-ahead log, full sync, foreign keys; checks the file's
/// integrity. Throws Error{locked, corrupt, unreadable}; a damaged file is never deleted or repaired here.
std::unique_ptr<Database> open_sqlite(const std::filesystem::path& file);

/// Connects to a PostgreSQL server (`postgresql://user@host/database`, or any libpq connection string) and holds the
/// database for this process alone. A connection that breaks is made again with the next statement outside a
/// transaction. Throws Error{unreadable, locked, lost}.
std::unique_ptr<Database> open_postgres(const std::string& connection);

}  // namespace headstock::db
