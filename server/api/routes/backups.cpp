// Backups, restoring a machine, and what the retention keeps.
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>

#include "db/hash.hpp"
#include "db/store.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/backup/backups.hpp"
#include "server/backup/retention.hpp"

namespace headstock::api {

namespace {

using access::Action;
using boost::asio::awaitable;

json shape(const db::BackupRow& row) {
  return {{"id", row.id},         {"file", row.file}, {"kind", row.kind}, {"machine", row.machine != 0 ? json(row.machine) : json(nullptr)},
          {"sha256", row.sha256}, {"bytes", row.bytes}, {"by", row.by},   {"at", time_json(row.at_ms)}};
}

/// A backup on its way to a browser, read on a worker.
class FileStream final : public ReplyStream {
 public:
  FileStream(Services& s, const std::filesystem::path& file, std::uint64_t size)
      : s_(s), size_(size), file_(std::fopen(file.c_str(), "rb")) {
    if (!file_) throw Refused("not_found", file.filename().string());
  }
  ~FileStream() override { std::fclose(file_); }
  FileStream(const FileStream&) = delete;
  FileStream& operator=(const FileStream&) = delete;
  std::uint64_t size() const override { return size_; }
  awaitable<std::size_t> read(char* into, std::size_t at_most) override {
    co_return co_await s_.workers.run([&] { return std::fread(into, 1, at_most, file_); });
  }

 private:
  Services& s_;
  std::uint64_t size_;
  std::FILE* file_;
};

/// A body into a file that vanishes unless it is kept.
struct Brought {
  explicit Brought(const std::filesystem::path& folder) : path(folder / ("brought-" + db::random_hex(8) + ".part")) {
    descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor < 0) throw Refused("disk_full");
  }
  ~Brought() {
    if (descriptor >= 0) ::close(descriptor);
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
  Brought(const Brought&) = delete;
  Brought& operator=(const Brought&) = delete;
  std::filesystem::path path;
  int descriptor = -1;
};

awaitable<db::BackupRow> receive_backup(Services& s, Call& call) {
  Brought brought(s.backups.folder());
  std::vector<char> piece(512 * 1024);
  while (const auto got = co_await call.upload->read(piece.data(), piece.size())) {
    const auto written = co_await s.workers.run([&] { return ::write(brought.descriptor, piece.data(), got); });
    if (written != static_cast<ssize_t>(got)) throw Refused("disk_full");
  }
  co_return co_await s.backups.keep(actor_of(call), brought.path);
}

void making_backups(Services& s, std::vector<Route>& routes) {
  const Need need = needs(Action::manage_backups);
  routes.push_back({.method = Method::get, .pattern = "/backups", .role = needs(Action::backup_machine), .summary = "Backups that are kept, newest first",
                    .response = "Backups", .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto rows = co_await s.store.run([](db::Database& db) { return db::backups(db); });
                      json items = json::array();
                      for (const auto& row : rows) items.push_back(shape(row));
                      co_return json_reply({{"items", std::move(items)}, {"next", nullptr}});
                    }});
  routes.push_back({.method = Method::post, .pattern = "/backups", .role = need, .summary = "Back up the whole server now, while it runs",
                    .takes = Takes::json, .response = "Backup", .status = 201, .errors = {"backup_running"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await s.backups.make_server(actor_of(call));
                      co_return json_reply(shape(row), 201);
                    }});
  routes.push_back({.method = Method::post, .pattern = "/backups/file", .role = need,
                    .summary = "Bring a backup file; it is checked whole before it is kept", .takes = Takes::bytes,
                    .response = "Backup", .status = 201, .errors = {"damaged_backup", "not_a_backup", "newer_backup", "too_large"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await receive_backup(s, call);
                      co_return json_reply(shape(row), 201);
                    }});
  routes.push_back({.method = Method::post, .pattern = "/machines/{id}/backup", .role = needs(Action::backup_machine),
                    .summary = "Back up everything of one machine now", .takes = Takes::json, .response = "Backup", .status = 201,
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await s.backups.make_machine(actor_of(call), call.id("id"));
                      co_return json_reply(shape(row), 201);
                    }});
}

void using_backups(Services& s, std::vector<Route>& routes) {
  const Need need = needs(Action::manage_backups);
  routes.push_back({.method = Method::get, .pattern = "/backups/{id}/file", .role = need,
                    .summary = "The file itself: it holds password hashes and keys, keep it safe", .response = "bytes",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto row = co_await s.store.run([id](db::Database& db) { return db::backup(db, id); });
                      if (!row) throw Refused("not_found", "backup:" + std::to_string(id));
                      Reply reply;
                      reply.content_type = "application/octet-stream";
                      reply.stream = std::make_unique<FileStream>(s, s.backups.path_of(*row), static_cast<std::uint64_t>(row->bytes));
                      reply.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + row->file + "\"");
                      co_return reply;
                    }});
  routes.push_back({.method = Method::get, .pattern = "/backups/{id}/verification", .role = needs(Action::backup_machine),
                    .summary = "Read it all again and compare every checksum", .response = "BackupVerification",
                    .errors = {"damaged_backup"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto manifest = co_await s.backups.verify(call.id("id"));
                      json answer = {{"whole", true}, {"entries", manifest.at("entries").size()}};
                      for (const char* key : {"kind", "made", "by", "version"}) answer[key] = manifest.value(key, "");
                      co_return json_reply(answer);
                    }});
  routes.push_back({.method = Method::del, .pattern = "/backups/{id}", .role = need, .summary = "Remove a backup and its file",
                    .status = 204, .handler = [&s](Call& call) -> awaitable<Reply> {
                      co_await s.backups.remove(actor_of(call), call.id("id"));
                      co_return empty_reply();
                    }});
  routes.push_back({.method = Method::post, .pattern = "/machines/{id}/restore", .role = needs(Action::restore_machine),
                    .summary = "Bring a machine's backup back to it, or to another with the same controller: programs into the "
                               "library and (released ones) to the machine, values that differ into its pages",
                    .takes = Takes::json, .request = "RestoreMachine", .response = "MachineRestored",
                    .errors = {"damaged_backup", "not_a_backup", "other_profile"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto answer = co_await s.backups.restore_machine(actor_of(call), call.body_number("backup"), call.id("id"));
                      co_return json_reply(answer);
                    }});
}

void keeping_settings(Services& s, std::vector<Route>& routes) {
  const auto shown = [](const backup::RetentionSettings& settings) {
    return json{{"events_days", settings.events_days},
                {"states_days", settings.states_days},
                {"transfers_days", settings.transfers_days},
                {"backup_every_hours", settings.backup_every_hours},
                {"backups_kept", settings.backups_kept}};
  };
  const Need need = needs(Action::manage_backups);
  routes.push_back({.method = Method::get, .pattern = "/settings/keeping", .role = need,
                    .summary = "How long things stay as recorded, how often the server is backed up; 0: for ever, never",
                    .response = "Keeping", .handler = [&s, shown](Call&) -> awaitable<Reply> {
                      const auto found = co_await s.store.run([](db::Database& db) { return backup::retention_settings(db); });
                      co_return json_reply(shown(found));
                    }});
  routes.push_back({.method = Method::patch, .pattern = "/settings/keeping", .role = need, .summary = "Change it",
                    .takes = Takes::json, .request = "Keeping", .response = "Keeping", .errors = {"bad_value"},
                    .handler = [&s, shown](Call& call) -> awaitable<Reply> {
                      backup::RetentionSettings wanted;
                      wanted.events_days = call.body_number("events_days");
                      wanted.states_days = call.body_number("states_days");
                      wanted.transfers_days = call.body_number("transfers_days");
                      wanted.backup_every_hours = call.body_number("backup_every_hours");
                      wanted.backups_kept = call.body_number("backups_kept");
                      const auto actor = actor_of(call);
                      co_await s.store.run([&](db::Database& db) { backup::set_retention(db, actor, wanted); });
                      co_return json_reply(shown(wanted));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/event-archives", .role = need,
                    .summary = "Files that hold events which the retention has put aside", .response = "EventArchives",
                    .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto rows = co_await s.store.run([](db::Database& db) { return db::event_archives(db); });
                      json items = json::array();
                      for (const auto& row : rows)
                        items.push_back({{"file", row.file}, {"sha256", row.sha256}, {"events", row.events},
                                         {"from", time_json(row.from_ms)}, {"to", time_json(row.to_ms)}, {"at", time_json(row.at_ms)}});
                      co_return json_reply({{"items", std::move(items)}, {"next", nullptr}});
                    }});
}

}  // namespace

std::vector<Route> backup_routes(Services& s) {
  std::vector<Route> routes;
  making_backups(s, routes);
  using_backups(s, routes);
  keeping_settings(s, routes);
  return routes;
}

}  // namespace headstock::api
