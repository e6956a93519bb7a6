#include "server/backup/backups.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "db/access_store.hpp"
#include "db/machine_store.hpp"
#include "db/program_store.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "protocol/process/log.hpp"
#include "server/access/audit.hpp"
#include "server/backup/archive.hpp"
#include "server/backup/machine_backup.hpp"
#include "server/backup/retention.hpp"
#include "server/backup/server_backup.hpp"
#include "server/library/programs.hpp"

namespace headstock::backup {
namespace {

namespace fs = std::filesystem;
using boost::asio::awaitable;
using nlohmann::json;

constexpr const char* kAutomatic = "server";  ///< by whom: the daily ones

struct Flag {
  explicit Flag(bool& the_flag) : flag(the_flag) { flag = true; }
  ~Flag() { flag = false; }
  Flag(const Flag&) = delete;
  Flag& operator=(const Flag&) = delete;
  bool& flag;
};

/// `headstock-lathe-1-2026-01-01T00-00-00Z.tar.zst`
std::string file_name(const std::string& what, std::int64_t at_ms) {
  std::string name = "headstock-";
  for (const char c : what) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    const bool upper = c >= 'A' && c <= 'Z';
    name += plain ? c : upper ? static_cast<char>(c - 'A' + 'a') : '-';
  }
  std::string time = db::iso_time(at_ms);
  std::ranges::replace(time, ':', '-');
  std::ranges::replace(time, '.', '-');
  return name + "-" + time + ".tar.zst";
}

json about(const char* kind, const access::Actor& actor, std::int64_t at_ms, const std::string& version, json facts) {
  facts["kind"] = kind;
  facts["by"] = actor.user;
  facts["made"] = db::iso_time(at_ms);
  facts["version"] = version;
  return facts;
}

std::string subject(std::int64_t id) {
  return "backup:" + std::to_string(id);
}

db::BackupRow require(db::Database& db, std::int64_t id) {
  const auto row = db::backup(db, id);
  if (!row) throw db::Refusal("not_found", subject(id));
  return *row;
}

}  // namespace

Backups::Backups(db::Store& store, db::Pool& worker, const db::Blobs& blobs, fs::path data_folder, std::string version)
    : store_(store), worker_(worker), blobs_(blobs), data_folder_(std::move(data_folder)), version_(std::move(version)) {
  fs::create_directories(folder());
  fs::permissions(folder(), fs::perms::owner_all);
  std::error_code ignored;
  // Halves of an earlier run.
  for (const auto& entry : fs::directory_iterator(folder(), ignored))
    if (entry.path().extension() == ".part" || entry.path().filename().string().starts_with("snapshot"))
      fs::remove(entry.path(), ignored);
}

Backups::~Backups() = default;

awaitable<db::BackupRow> Backups::registered(access::Actor actor, db::BackupRow row) {
  const auto note = [&](db::Database& db) {
    db::Transaction transaction(db);
    row.id = db::insert_backup(db, row);
    access::record(db, actor, "backup.make", subject(row.id), {{"file", row.file}, {"kind", row.kind}, {"sha256", row.sha256}});
    transaction.commit();
  };
  co_await store_.run(note);
  co_return row;
}

awaitable<db::BackupRow> Backups::make_server(access::Actor actor) {
  access::demand(actor, access::Action::manage_backups);
  if (making_) throw db::Refusal("backup_running");
  const Flag making(making_);
  const auto now = db::now_ms();
  const auto begin = [this](db::Database& db) { return db.snapshot(folder()); };
  const std::unique_ptr<db::Snapshot> snapshot = co_await store_.run(begin);
  const auto step = [&](db::Database&) { return snapshot->step(); };
  // Between the pieces everybody else has a turn.
  while (co_await store_.run(step)) {
  }
  db::BackupRow row;
  row.file = file_name("server", now);
  row.kind = "server";
  row.by = actor.user;
  row.at_ms = now;
  const auto pack = [&] {
    ArchiveWriter archive(path_of(row));
    const auto copy = snapshot->open();
    const json facts = write_server(archive, *copy, blobs_, data_folder_);
    const auto finished = archive.finish(about("server", actor, now, version_, facts));
    row.sha256 = finished.sha256;
    row.bytes = static_cast<std::int64_t>(finished.bytes);
  };
  co_await worker_.run(pack);
  co_return co_await registered(actor, row);
}

awaitable<db::BackupRow> Backups::make_machine(access::Actor actor, std::int64_t machine) {
  access::demand(actor, access::Action::backup_machine);
  const auto read = [machine](db::Database& db) { return machine_content(db, machine); };
  const MachineContent content = co_await store_.run(read);
  const auto now = db::now_ms();
  db::BackupRow row;
  row.file = file_name(content.machine.name + "-" + std::to_string(machine), now);
  row.kind = "machine";
  row.machine = machine;
  row.by = actor.user;
  row.at_ms = now;
  const auto pack = [&] {
    ArchiveWriter archive(path_of(row));
    const json facts = write_machine(archive, content, blobs_);
    const auto finished = archive.finish(about("machine", actor, now, version_, facts));
    row.sha256 = finished.sha256;
    row.bytes = static_cast<std::int64_t>(finished.bytes);
  };
  co_await worker_.run(pack);
  co_return co_await registered(actor, row);
}

awaitable<db::BackupRow> Backups::keep(access::Actor actor, fs::path brought) {
  access::demand(actor, access::Action::manage_backups);
  json manifest;
  const auto check = [&] { manifest = backup::verify(brought); };
  co_await worker_.run(check);
  db::BackupRow row;
  row.kind = manifest.value("kind", "");
  if (row.kind != "server" && row.kind != "machine") throw db::Refusal("not_a_backup", row.kind);
  row.at_ms = db::now_ms();
  row.by = actor.user;
  const std::string what = row.kind == "machine" ? manifest.at("machine").value("name", "machine") : "server";
  row.file = file_name(what + "-brought", row.at_ms);
  const auto place = [&] {
    db::Sha256 hash;
    const auto mapped_bytes = fs::file_size(brought);
    std::unique_ptr<std::FILE, int (*)(std::FILE*)> in(std::fopen(brought.c_str(), "rb"), &std::fclose);
    std::vector<char> piece(1u << 18);
    while (in) {
      const std::size_t got = std::fread(piece.data(), 1, piece.size(), in.get());
      if (got == 0) break;
      hash.add({piece.data(), got});
    }
    row.sha256 = hash.hex();
    row.bytes = static_cast<std::int64_t>(mapped_bytes);
    fs::rename(brought, path_of(row));
  };
  co_await worker_.run(place);
  co_return co_await registered(actor, row);
}

awaitable<void> Backups::remove(access::Actor actor, std::int64_t id) {
  access::demand(actor, access::Action::manage_backups);
  const auto forget = [&](db::Database& db) {
    const auto row = require(db, id);
    db::Transaction transaction(db);
    db::remove_backup(db, id, db::now_ms());
    access::record(db, actor, "backup.remove", subject(id), {{"file", row.file}});
    transaction.commit();
    return row;
  };
  const auto row = co_await store_.run(forget);
  std::error_code ignored;
  fs::remove(path_of(row), ignored);
}

awaitable<json> Backups::verify(std::int64_t id) {
  const auto find = [id](db::Database& db) { return require(db, id); };
  const auto row = co_await store_.run(find);
  json manifest;
  const auto check = [&] { manifest = backup::verify(path_of(row)); };
  co_await worker_.run(check);
  co_return manifest;
}

awaitable<json> Backups::restore_machine(access::Actor actor, std::int64_t id, std::int64_t machine) {
  access::demand(actor, access::Action::restore_machine);
  const auto find = [id](db::Database& db) { return require(db, id); };
  const auto row = co_await store_.run(find);
  MachineArchive content;
  const auto read = [&] { content = read_machine(path_of(row), blobs_); };
  co_await worker_.run(read);
  // Programs first: what is in the library can be looked at, whatever comes after.
  json programs = json::array();
  std::vector<std::pair<std::int64_t, std::int64_t>> to_send;
  std::vector<std::size_t> places;
  bool same_file = true;
  std::vector<db::BlobRow> texts;
  const auto examine = [&] {
    for (const auto& program : content.programs) {
      library::Upload upload(blobs_);
      const auto text = blobs_.map(program.sha256);
      upload.append(text->view());
      texts.push_back(upload.finish());
    }
  };
  co_await worker_.run(examine);
  const auto now = db::now_ms();
  const auto into_library = [&](db::Database& db) {
    const auto target = db::machine(db, machine);
    if (!target) throw db::Refusal("not_found", "machine:" + std::to_string(machine));
    if (target->profile != content.profile) throw db::Refusal("other_profile", content.profile);
    same_file = target->toml == content.toml;
    db::Transaction transaction(db);
    for (std::size_t i = 0; i < content.programs.size(); ++i) {
      const auto& program = content.programs[i];
      json entry = {{"name", program.name}, {"sha256", program.sha256}};
      auto revision = db::revision_of_content(db, program.sha256);
      if (!revision) {
        access::Actor librarian = actor;
        librarian.role = std::max(actor.role, access::Role::programmer);
        librarian.rights = nullptr;
        const auto added = library::add_revision(db, librarian, {"/restored/" + content.name, program.name}, texts[i],
                                                 "restored from " + row.file, "restore", now);
        revision = db::revision(db, added.program.id, added.revision.number);
      }
      entry["program"] = revision->program;
      entry["revision"] = revision->number;
      const auto released = db::current_release(db, revision->program);
      const bool current = released && released->revision == revision->number;
      entry["state"] = current ? "sending" : "not_released";
      if (current) {
        to_send.emplace_back(revision->program, revision->number);
        places.push_back(programs.size());
      }
      programs.push_back(std::move(entry));
    }
    access::record(db, actor, "backup.restore", "machine:" + std::to_string(machine),
                   {{"file", row.file}, {"of", content.name}, {"programs", std::to_string(content.programs.size())},
                    {"values", std::to_string(content.values.size())}});
    transaction.commit();
  };
  co_await store_.run(into_library);
  for (std::size_t i = 0; i < to_send.size(); ++i) {
    json sent = {{"state", "failed"}, {"reason", "not_connected"}};
    if (restorer_.send) sent = co_await restorer_.send(actor, to_send[i].first, to_send[i].second, machine);
    programs[places[i]].update(sent);
  }
  json values = {{"state", "not_written"}, {"in_backup", content.values.size()}};
  if (restorer_.write) {
    values = co_await restorer_.write(actor, machine, content.values, "restored from " + row.file);
    values["in_backup"] = content.values.size();
  }
  co_return json{{"machine", machine},
                 {"of", content.name},
                 {"made", content.manifest.value("made", "")},
                 {"programs", std::move(programs)},
                 {"values", std::move(values)},
                 {"machine_file", same_file ? "same" : "differs"},
                 {"not_here", content.manifest.value("not_here", json::array())}};
}

awaitable<void> Backups::make_due_backup() {
  const auto due = [](db::Database& db) {
    const auto settings = retention_settings(db);
    if (settings.backup_every_hours == 0) return false;
    const auto now = db::now_ms();
    std::int64_t last = 0;
    for (const auto& row : db::backups(db))
      if (row.kind == "server") last = std::max(last, row.at_ms);
    if (last == 0) {
      // A new server has nothing worth keeping yet: counted from its first minute.
      const auto since = db::setting(db, "keeping.since");
      if (!since) db::put_setting(db, "keeping.since", std::to_string(now));
      last = since ? std::stoll(*since) : now;
    }
    // A clock that was set back must not stop the backups for years.
    return now - last >= settings.backup_every_hours * db::kHourMs || last - now > db::kHourMs;
  };
  if (!co_await store_.run(due)) co_return;
  const auto row = co_await make_server(access::Actor{});
  log::info("backup {} ({} MiB)", row.file, row.bytes >> 20);
  const auto old_ones = [](db::Database& db) {
    const auto kept = retention_settings(db).backups_kept;
    std::vector<std::int64_t> ids;
    std::int64_t seen = 0;
    for (const auto& one : db::backups(db))
      if (one.kind == "server" && one.by == kAutomatic && ++seen > kept) ids.push_back(one.id);
    return ids;
  };
  for (const auto id : co_await store_.run(old_ones)) co_await remove(access::Actor{}, id);
}

awaitable<void> Backups::thin_out() {
  const auto now = db::now_ms();
  const auto read = [](db::Database& db) {
    std::vector<std::int64_t> machines;
    for (const auto& machine : db::machines(db)) machines.push_back(machine.id);
    return std::pair(retention_settings(db), machines);
  };
  const auto [settings, machines] = co_await store_.run(read);
  if (settings.states_days > 0) {
    const auto before = now - settings.states_days * db::kDayMs;
    for (const auto machine : machines) {
      const auto piece = [&](db::Database& db) { return coarsen_states(db, machine, before); };
      while (co_await store_.run(piece)) {
      }
    }
  }
  if (settings.events_days > 0) {
    const auto before = now - settings.events_days * db::kDayMs;
    const auto piece = [&](db::Database& db) { return archive_events(db, data_folder_, before, db::now_ms()); };
    while (co_await store_.run(piece) > 0) {
    }
  }
  if (settings.transfers_days > 0) {
    const auto before = now - settings.transfers_days * db::kDayMs;
    const auto forget = [&](db::Database& db) { return forget_transfers(db, before); };
    co_await store_.run(forget);
  }
}

awaitable<void> Backups::every_minute() {
  if (working_) co_return;
  const Flag working(working_);
  co_await make_due_backup();
  co_await thin_out();
}

}  // namespace headstock::backup
