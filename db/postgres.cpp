// The only file that knows PostgreSQL (libpq). What the stores promise on SQLite holds here too: one process a
// database, a statement at a time, a transaction that failed is undone whole.
#include <libpq-fe.h>

#include <array>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "db/database.hpp"
#include "db/postgres_sql.hpp"

namespace headstock::db {
namespace {

using namespace std::chrono_literals;

// Type numbers of PostgreSQL's catalogue, fixed for ever.
constexpr Oid kBool = 16, kInt8 = 20, kInt2 = 21, kInt4 = 23, kText = 25, kFloat4 = 700, kFloat8 = 701, kNumeric = 1700, kUnknown = 0;
/// Every Headstock asks for this advisory lock: who has it has the database.
constexpr const char* kTakeDatabase = "SELECT pg_try_advisory_lock(7239468312)";
/// After a break the old session may hold the lock until the server has noticed it.
constexpr auto kLockPatience = 3s;
constexpr std::size_t kMostPrepared = 256;

struct Clear {
  void operator()(PGresult* result) const { PQclear(result); }
};
using Result = std::unique_ptr<PGresult, Clear>;

Problem problem_of(std::string_view state) {
  struct Row {
    std::string_view prefix;
    Problem problem;
  };
  // SQLSTATE classes (PostgreSQL manual, appendix A); the longer ones first.
  static constexpr Row rows[] = {
      {"53100", Problem::disk_full}, {"53", Problem::unreadable}, {"54", Problem::internal},
      {"58", Problem::unreadable},   {"57P", Problem::lost},      {"08", Problem::lost},
      {"23", Problem::constraint},   {"40", Problem::locked},     {"55P03", Problem::locked},
      {"28", Problem::unreadable},   {"42501", Problem::unreadable}, {"3D", Problem::unreadable},
      {"25006", Problem::unreadable}, {"XX001", Problem::corrupt}, {"XX002", Problem::corrupt},
  };
  for (const Row& row : rows)
    if (state.starts_with(row.prefix)) return row.problem;
  return Problem::internal;
}

std::string words_for(Problem problem, const std::string& place, std::string detail) {
  while (!detail.empty() && detail.back() == '\n') detail.pop_back();
  for (char& c : detail)
    if (c == '\n') c = ' ';
  switch (problem) {
    case Problem::locked:
      return place + ": in use by another server. Stop it, or give this one another database.";
    case Problem::disk_full:
      return place + ": no room on the database server's disk; the change was undone. Free some space.";
    case Problem::lost:
      return place + ": the connection to the database server is lost (" + detail + "); trying again.";
    case Problem::unreadable:
      return place + ": cannot be used (" + detail + "). Check the address, the user's rights and the server.";
    case Problem::corrupt:
      return place + ": the database is damaged (" + detail + "). Nothing was changed. Restore a backup.";
    default:
      return place + ": " + detail;
  }
}

/// PostgreSQL keeps only true UTF-8 without the zero character. What a machine sent must not be refused for ever for
/// that: such bytes become U+FFFD.
std::string storable(const std::string& text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size();) {
    const auto lead = static_cast<unsigned char>(text[at]);
    std::size_t length = lead < 0x80 ? 1 : lead >= 0xC2 && lead < 0xE0 ? 2 : lead >= 0xE0 && lead < 0xF0 ? 3 : lead >= 0xF0 && lead < 0xF5 ? 4 : 0;
    bool good = length > 0 && lead != 0 && at + length <= text.size();
    for (std::size_t i = 1; good && i < length; ++i) good = (static_cast<unsigned char>(text[at + i]) & 0xC0) == 0x80;
    if (good && length > 2) {  // overlong forms, surrogates, above U+10FFFF
      const auto second = static_cast<unsigned char>(text[at + 1]);
      good = !(lead == 0xE0 && second < 0xA0) && !(lead == 0xED && second > 0x9F) && !(lead == 0xF0 && second < 0x90) &&
             !(lead == 0xF4 && second > 0x8F);
    }
    if (good)
      out.append(text, at, length);
    else
      out += "\xEF\xBF\xBD";
    at += good ? length : 1;
  }
  return out;
}

/// Values as libpq takes them: texts, with the type said where it is known.
struct Parameters {
  explicit Parameters(const Values& values) {
    texts.reserve(values.size());
    for (const Value& value : values) std::visit(*this, value.storage());
    for (std::size_t i = 0; i < values.size(); ++i)
      pointers.push_back(types[i] == kUnknown ? nullptr : texts[i].c_str());
  }
  void operator()(std::nullptr_t) { add({}, kUnknown); }
  void operator()(std::int64_t number) { add(std::to_string(number), kInt8); }
  void operator()(double number) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    add(std::string(digits.data(), end), kFloat8);
  }
  void operator()(const std::string& text) { add(storable(text), kText); }
  void add(std::string text, Oid type) {
    texts.push_back(std::move(text));
    types.push_back(type);
  }
  int count() const { return static_cast<int>(types.size()); }

  std::vector<std::string> texts;
  std::vector<Oid> types;
  std::vector<const char*> pointers;
};

class PostgresRow final : public Row {
 public:
  explicit PostgresRow(const PGresult* result) : result_(result) {}
  int row = 0;
  bool is_null(int column) const override { return PQgetisnull(result_, row, column) != 0; }
  std::int64_t integer(int column) const override {
    const std::string_view text = view(column);
    if (text == "t") return 1;
    std::int64_t number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    // 1.5e+06 and the like: a whole number that a function has made a real one.
    if (error == std::errc() && end != text.data() + text.size() && *end != '.') return static_cast<std::int64_t>(real(column));
    return number;
  }
  double real(int column) const override {
    const std::string_view text = view(column);
    double number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
  }
  std::string text(int column) const override { return std::string(view(column)); }
  Value value(int column) const override {
    if (is_null(column)) return {};
    switch (PQftype(result_, column)) {
      case kBool:
      case kInt2:
      case kInt4:
      case kInt8:
        return integer(column);
      case kFloat4:
      case kFloat8:
      case kNumeric:
        return real(column);
      default:
        return text(column);
    }
  }

 private:
  std::string_view view(int column) const {
    return {PQgetvalue(result_, row, column), static_cast<std::size_t>(PQgetlength(result_, row, column))};
  }
  const PGresult* result_;
};

/// Its owner has the database for itself and may write; others look at one moment of it.
enum class Session { owner, looking };

class Postgres final : public Database {
 public:
  explicit Postgres(std::string connection, Session session = Session::owner)
      : connection_(std::move(connection)), session_(session) {
    try {
      connect();
    } catch (...) {
      PQfinish(handle_);
      throw;
    }
  }
  ~Postgres() override { PQfinish(handle_); }
  Postgres(const Postgres&) = delete;
  Postgres& operator=(const Postgres&) = delete;

  void script(const std::string& sql) override {
    demand_connection();
    demand(Result(PQexec(handle_, postgres_script(sql).c_str())).get());
  }

  bool has_table(std::string_view name) override {
    return integer("SELECT 1 FROM information_schema.tables WHERE table_schema = current_schema() AND table_name = ?",
                   {name})
        .has_value();
  }
  std::string place() const override { return place_; }

  std::vector<TableShape> tables() override {
    std::vector<TableShape> found;
    // In the order in which they were made: a table refers only to older ones.
    each("SELECT relname FROM pg_class WHERE relkind = 'r' AND relnamespace = current_schema()::regnamespace ORDER BY oid",
         {}, [&](const Row& row) { found.push_back({row.text(0), {}}); });
    for (TableShape& table : found)
      each("SELECT column_name FROM information_schema.columns WHERE table_schema = current_schema() AND table_name = ? "
           "ORDER BY ordinal_position",
           {table.name}, [&](const Row& row) { table.columns.push_back(row.text(0)); });
    return found;
  }

  std::unique_ptr<Snapshot> snapshot(const std::filesystem::path&) override;

  void follow_ids() override {
    std::vector<std::string> identities;
    each("SELECT table_name FROM information_schema.columns WHERE table_schema = current_schema() AND column_name = 'id' "
         "AND is_identity = 'YES'",
         {}, [&](const Row& row) { identities.push_back(row.text(0)); });
    for (const std::string& table : identities)
      integer("SELECT setval(pg_get_serial_sequence('" + table + "', 'id'), COALESCE((SELECT MAX(id) FROM " + table +
              "), 0) + 1, false)");
  }

  void set_guard(const std::string& table, const std::string& trigger, Guard guard) override {
    script("ALTER TABLE " + table + (guard == Guard::open ? " DISABLE" : " ENABLE") + " TRIGGER " + trigger);
  }

 protected:
  std::int64_t run(std::string_view sql, const Values& values, const RowHandler& row) override {
    if (streaming_) throw Error(Problem::internal, "a row's handler used the database");
    demand_connection();
    if (sql == "BEGIN IMMEDIATE") sql = "BEGIN";
    const Parameters parameters(values);
    send(sql, parameters);
    return row ? stream(row) : finish();
  }

 private:
  void connect() {
    const char* const keywords[] = {"dbname", "application_name", "connect_timeout", "client_encoding",
                                    "keepalives_idle", "keepalives_interval", "tcp_user_timeout", nullptr};
    const char* const values[] = {connection_.c_str(), "headstock", "5", "UTF8", "10", "5", "15000", nullptr};
    handle_ = PQconnectdbParams(keywords, values, 1);
    place_ = std::string("postgresql ") + word(PQhost(handle_)) + " " + word(PQdb(handle_));
    if (PQstatus(handle_) != CONNECTION_OK) {
      const std::string detail = word(PQerrorMessage(handle_));
      PQfinish(std::exchange(handle_, nullptr));
      throw Error(Problem::unreadable, words_for(Problem::unreadable, place_, detail));
    }
    prepare_session();
  }

  static std::string word(const char* text) { return text ? text : ""; }

  void prepare_session() {
    prepared_.clear();
    PQsetNoticeReceiver(handle_, [](void*, const PGresult*) {}, nullptr);
    // What has been acknowledged to a machine must be on the disk, whatever the server's default is.
    demand(Result(PQexec(handle_, "SET synchronous_commit TO on; SET extra_float_digits TO 1; SET standard_conforming_strings TO on"))
               .get());
    if (session_ == Session::looking) {
      demand(Result(PQexec(handle_, "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY")).get());
      // The moment is that of the first query, not of BEGIN.
      demand(Result(PQexec(handle_, "SELECT 1")).get());
      return;
    }
    take_database();
    demand(Result(PQexec(handle_,
                         "CREATE OR REPLACE FUNCTION headstock_refuse() RETURNS trigger LANGUAGE plpgsql AS $$ "
                         "BEGIN RAISE EXCEPTION '%', TG_ARGV[0] USING ERRCODE = '23000'; END $$"))
               .get());
  }

  void take_database() {
    const auto until = std::chrono::steady_clock::now() + kLockPatience;
    for (;;) {
      const Result result(PQexec(handle_, kTakeDatabase));
      demand(result.get());
      if (word(PQgetvalue(result.get(), 0, 0)) == "t") return;
      if (std::chrono::steady_clock::now() >= until)
        throw Error(Problem::locked, words_for(Problem::locked, place_, ""));
      std::this_thread::sleep_for(100ms);
    }
  }

  void demand_connection() {
    if (broken_ && depth() > 0)
      throw Error(Problem::lost, words_for(Problem::lost, place_, "the transaction is undone"));
    if (handle_ && PQstatus(handle_) == CONNECTION_OK && !broken_) return;
    if (depth() > 0 || (session_ == Session::looking && handle_)) fail_lost();
    if (handle_)
      PQreset(handle_);
    else
      connect();
    if (PQstatus(handle_) != CONNECTION_OK) fail_lost();
    broken_ = false;
    prepare_session();
  }

  [[noreturn]] void fail_lost() {
    broken_ = true;
    throw Error(Problem::lost, words_for(Problem::lost, place_, word(handle_ ? PQerrorMessage(handle_) : "")));
  }

  /// The name of the statement, prepared with the types of its values; empty when too many are prepared already.
  std::string prepare(std::string_view sql, const Parameters& parameters) {
    std::string key(sql);
    for (const Oid type : parameters.types) key.append(1, '\x1f').append(std::to_string(type));
    const auto found = prepared_.find(key);
    if (found != prepared_.end()) return found->second;
    if (prepared_.size() >= kMostPrepared) return {};
    const std::string name = "h" + std::to_string(prepared_.size());
    demand(Result(PQprepare(handle_, name.c_str(), postgres_statement(sql).c_str(), parameters.count(),
                            parameters.types.data()))
               .get());
    prepared_.emplace(std::move(key), name);
    return name;
  }

  static bool for_preparing(std::string_view sql) {
    return sql.starts_with("SELECT") || sql.starts_with("INSERT") || sql.starts_with("UPDATE") || sql.starts_with("DELETE");
  }

  void send(std::string_view sql, const Parameters& parameters) {
    const std::string name = for_preparing(sql) ? prepare(sql, parameters) : std::string();
    const int sent = name.empty()
                         ? PQsendQueryParams(handle_, postgres_statement(sql).c_str(), parameters.count(),
                                             parameters.types.data(), parameters.pointers.data(), nullptr, nullptr, 0)
                         : PQsendQueryPrepared(handle_, name.c_str(), parameters.count(), parameters.pointers.data(),
                                               nullptr, nullptr, 0);
    if (sent != 1) fail_lost();
  }

  std::int64_t finish() {
    Result last;
    while (Result result{PQgetResult(handle_)}) last = std::move(result);
    demand(last.get());
    return changed(last.get());
  }

  static std::int64_t changed(const PGresult* result) {
    return std::strtoll(PQcmdTuples(const_cast<PGresult*>(result)), nullptr, 10);
  }

  /// Row by row: a year of events is never in memory.
  std::int64_t stream(const RowHandler& row) {
    PQsetSingleRowMode(handle_);
    std::exception_ptr thrown;
    Result last;
    std::int64_t count = 0;
    while (Result result{PQgetResult(handle_)}) {
      if (PQresultStatus(result.get()) == PGRES_SINGLE_TUPLE) {
        ++count;
        if (!thrown) hand_over(row, PostgresRow(result.get()), thrown);
      } else {
        last = std::move(result);
      }
    }
    if (thrown) std::rethrow_exception(thrown);
    demand(last.get());
    return count;
  }

  void hand_over(const RowHandler& row, const PostgresRow& view, std::exception_ptr& thrown) {
    streaming_ = true;
    try {
      row(view);
    } catch (...) {
      thrown = std::current_exception();
      if (PGcancel* const cancel = PQgetCancel(handle_)) {
        std::array<char, 256> ignored{};
        PQcancel(cancel, ignored.data(), static_cast<int>(ignored.size()));
        PQfreeCancel(cancel);
      }
    }
    streaming_ = false;
  }

  void demand(const PGresult* result) {
    if (!result || PQstatus(handle_) != CONNECTION_OK) fail_lost();
    const auto status = PQresultStatus(result);
    if (status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK) return;
    const Problem problem = problem_of(word(PQresultErrorField(result, PG_DIAG_SQLSTATE)));
    if (problem == Problem::lost) broken_ = true;
    throw Error(problem, words_for(problem, place_, word(PQresultErrorMessage(result))));
  }

  std::string connection_, place_;
  Session session_;
  PGconn* handle_ = nullptr;
  bool broken_ = false;     ///< until a new connection has been made
  bool streaming_ = false;
  std::unordered_map<std::string, std::string> prepared_;
};

/// A second connection that sees one moment; PostgreSQL keeps it apart by itself.
class PostgresSnapshot final : public Snapshot {
 public:
  explicit PostgresSnapshot(const std::string& connection)
      : database_(std::make_unique<Postgres>(connection, Session::looking)) {}
  bool step() override { return false; }
  std::unique_ptr<Database> open() override { return std::move(database_); }

 private:
  std::unique_ptr<Database> database_;
};

std::unique_ptr<Snapshot> Postgres::snapshot(const std::filesystem::path&) {
  return std::make_unique<PostgresSnapshot>(connection_);
}

}  // namespace

std::unique_ptr<Database> open_postgres(const std::string& connection) {
  return std::make_unique<Postgres>(connection);
}

}  // namespace headstock::db
