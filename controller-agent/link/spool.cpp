#include "link/spool.hpp"

#include <ctime>
#include <mutex>
#include <utility>

#include "link/sqlite.hpp"
#include "protocol/wire/digest.hpp"

namespace headstock::link {
namespace {

constexpr std::int64_t kFormat = 1;
constexpr std::size_t kMaxBody = 64u << 10;

std::string make_uuid() {
  // Version 4, as RFC 9562 writes it.
  std::string hex = wire::random_hex(16);
  hex[12] = '4';
  hex[16] = "89ab"[static_cast<unsigned char>(hex[16]) % 4];
  for (const std::size_t at : {8u, 13u, 18u, 23u}) hex.insert(at, 1, '-');
  return hex;
}

/// A transaction that is undone unless it was committed.
class Transaction {
 public:
  explicit Transaction(sqlite::Connection& db) : db_(db) { db_.run("BEGIN IMMEDIATE"); }
  ~Transaction() {
    if (open_) sqlite3_exec(db_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit() {
    db_.run("COMMIT");
    open_ = false;
  }

 private:
  sqlite::Connection& db_;
  bool open_ = true;
};

}  // namespace

struct Spool::Impl {
  mutable std::mutex mutex;  // one connection, short transactions: a lock is simpler than two connections
  sqlite::Connection db;
  std::string id;
  std::uint64_t last = 0, acknowledged = 0;
  std::function<void()> notify;

  void open(const std::filesystem::path& file);
  void create();
  std::string meta(const char* key) const;
  void set_meta(const char* key, const std::string& value);
};

std::string Spool::Impl::meta(const char* key) const {
  sqlite::Statement read(db, "SELECT value FROM meta WHERE key=?");
  read.bind(1, std::string_view(key));
  return read.step() ? read.text(0) : std::string();
}

void Spool::Impl::set_meta(const char* key, const std::string& value) {
  sqlite::Statement write(
      db, "INSERT INTO meta(key,value) VALUES(?,?) ON CONFLICT(key) DO UPDATE SET value=excluded.value");
  write.bind(1, std::string_view(key)).bind(2, value).step();
}

void Spool::Impl::create() {
  Transaction transaction(db);
  db.run(
      "CREATE TABLE meta(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;"
      // AUTOINCREMENT: a sequence is never used again, though its row was acknowledged and removed.
      "CREATE TABLE event(sequence INTEGER PRIMARY KEY AUTOINCREMENT, at_ms INTEGER NOT NULL, kind TEXT NOT "
      "NULL,"
      " body TEXT NOT NULL);"
      "CREATE TABLE retained(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;");
  set_meta("format", std::to_string(kFormat));
  set_meta("id", make_uuid());
  transaction.commit();
}

void Spool::Impl::open(const std::filesystem::path& file) {
  db.open(file.string());
  sqlite3_busy_timeout(db.get(), 2'000);
  // Exclusive: two agents on one spool would send each other's parts. The lock is taken with the first read.
  db.run(
      "PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA "
      "temp_store=MEMORY;");
  {
    sqlite::Statement check(db, "PRAGMA quick_check(1)");
    if (!check.step() || check.text(0) != "ok")
      throw SpoolDamaged(
          file.string() +
          ": the spool of events is damaged; nothing was changed. Set the file aside and start again");
  }
  bool empty = false;
  {
    sqlite::Statement tables(db, "SELECT count(*) FROM sqlite_schema");
    empty = tables.step() && tables.integer(0) == 0;
  }
  if (empty) create();
  const std::string format = meta("format");
  if (format != std::to_string(kFormat))
    throw SpoolError(file.string() + ": written by another version of the program (format " + format +
                     "), not opened");
  id = meta("id");
  sqlite::Statement sequence(db, "SELECT seq FROM sqlite_sequence WHERE name='event'");
  last = sequence.step() ? static_cast<std::uint64_t>(sequence.integer(0)) : 0;
  sqlite::Statement first(db, "SELECT min(sequence) FROM event");
  acknowledged =
      first.step() && first.integer(0) > 0 ? static_cast<std::uint64_t>(first.integer(0)) - 1 : last;
}

Spool::Spool(std::filesystem::path file) : impl_(std::make_unique<Impl>()) {
  impl_->open(file);
}
Spool::~Spool() = default;

std::filesystem::path Spool::set_aside(const std::filesystem::path& file) {
  char stamp[32];
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::strftime(stamp, sizeof stamp, "%Y%m%dT%H%M%SZ", &utc);
  std::filesystem::path aside = file.string() + ".damaged-" + stamp;
  for (int n = 2; std::filesystem::exists(aside); ++n)
    aside = file.string() + ".damaged-" + stamp + "-" + std::to_string(n);
  for (const char* part : {"", "-wal", "-shm"}) {
    const std::filesystem::path from = file.string() + part;
    if (!std::filesystem::exists(from)) continue;
    std::error_code error;
    std::filesystem::rename(from, aside.string() + part, error);
    if (error) throw SpoolError(from.string() + ": cannot be set aside: " + error.message());
  }
  return aside;
}

const std::string& Spool::id() const {
  return impl_->id;
}

std::uint64_t Spool::commit(std::span<const NewEvent> events, std::span<const RetainedValue> retained) {
  std::function<void()> notify;
  std::uint64_t last = 0;
  {
    const std::scoped_lock lock(impl_->mutex);
    auto& db = impl_->db;
    for (const NewEvent& event : events)
      if (event.body.size() > kMaxBody)
        throw SpoolError("an event of " + std::to_string(event.body.size()) + " bytes");
    last = impl_->last;
    if (!events.empty() || !retained.empty()) {
      Transaction transaction(db);
      sqlite::Statement insert(db, "INSERT INTO event(at_ms,kind,body) VALUES(?,?,?)");
      for (const NewEvent& event : events) {
        insert.bind(1, event.at_ms).bind(2, event.kind).bind(3, event.body).step();
        last = static_cast<std::uint64_t>(sqlite3_last_insert_rowid(db.get()));
        insert.reset();
      }
      sqlite::Statement keep(db,
                             "INSERT INTO retained(key,value) VALUES(?,?) "
                             "ON CONFLICT(key) DO UPDATE SET value=excluded.value");
      sqlite::Statement erase(db, "DELETE FROM retained WHERE key=?");
      for (const RetainedValue& entry : retained) {
        if (entry.value) {
          keep.bind(1, entry.key).bind(2, *entry.value).step();
          keep.reset();
        } else {
          erase.bind(1, entry.key).step();
          erase.reset();
        }
      }
      transaction.commit();
      impl_->last = last;
    }
    if (!events.empty()) notify = impl_->notify;
  }
  if (notify) notify();
  return last;
}

std::vector<SpooledEvent> Spool::read_after(std::uint64_t sequence, std::size_t at_most,
                                            std::size_t max_bytes) const {
  const std::scoped_lock lock(impl_->mutex);
  std::vector<SpooledEvent> events;
  if (impl_->last <= sequence) return events;
  sqlite::Statement read(
      impl_->db, "SELECT sequence,at_ms,kind,body FROM event WHERE sequence>? ORDER BY sequence LIMIT ?");
  read.bind(1, static_cast<std::int64_t>(sequence)).bind(2, static_cast<std::int64_t>(at_most));
  std::size_t bytes = 0;
  while (read.step()) {
    SpooledEvent event;
    event.sequence = static_cast<std::uint64_t>(read.integer(0));
    event.at_ms = read.integer(1);
    event.kind = read.text(2);
    event.body = read.text(3);
    bytes += event.body.size();
    if (!events.empty() && bytes > max_bytes) break;
    events.push_back(std::move(event));
  }
  return events;
}

void Spool::acknowledge(std::uint64_t sequence) {
  const std::scoped_lock lock(impl_->mutex);
  if (sequence <= impl_->acknowledged) return;
  sequence = std::min(sequence, impl_->last);
  // An acknowledgement that is lost in a power cut only repeats events the server recognises: no wait for the
  // disk.
  impl_->db.run("PRAGMA synchronous=NORMAL");
  try {
    sqlite::Statement erase(impl_->db, "DELETE FROM event WHERE sequence<=?");
    erase.bind(1, static_cast<std::int64_t>(sequence)).step();
  } catch (...) {
    impl_->db.run("PRAGMA synchronous=FULL");
    throw;
  }
  impl_->db.run("PRAGMA synchronous=FULL");
  impl_->acknowledged = sequence;
}

std::uint64_t Spool::last_sequence() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->last;
}
std::uint64_t Spool::acknowledged() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->acknowledged;
}
std::uint64_t Spool::pending() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->last - impl_->acknowledged;
}

std::optional<std::string> Spool::retained(std::string_view key) const {
  const std::scoped_lock lock(impl_->mutex);
  sqlite::Statement read(impl_->db, "SELECT value FROM retained WHERE key=?");
  read.bind(1, key);
  if (!read.step()) return std::nullopt;
  return read.text(0);
}

std::map<std::string, std::string> Spool::all_retained() const {
  const std::scoped_lock lock(impl_->mutex);
  std::map<std::string, std::string> values;
  sqlite::Statement read(impl_->db, "SELECT key,value FROM retained");
  while (read.step()) values.emplace(read.text(0), read.text(1));
  return values;
}

void Spool::on_commit(std::function<void()> notify) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->notify = std::move(notify);
}

}  // namespace headstock::link
