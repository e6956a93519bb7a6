// Backups that are made, kept, downloaded and restored, and the daily work of the retention. Network thread; the copying
// is done in small pieces on the store's thread, the packing on a worker.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "db/backup_store.hpp"
#include "db/blobs.hpp"
#include "server/access/role.hpp"

namespace headstock::db {
class Store;
class Pool;
}  // namespace headstock::db

namespace headstock::backup {

/// How a machine gets back what belongs to it. What cannot be done is said in the answer, never skipped silently.
struct Restorer {
  /// Sends a released program. @return the transfer's state and reason as JSON.
  std::function<boost::asio::awaitable<nlohmann::json>(access::Actor, std::int64_t program, std::int64_t revision, std::int64_t machine)> send;
  /// Writes the values that differ and reads them back. @return what became of it as JSON.
  std::function<boost::asio::awaitable<nlohmann::json>(access::Actor, std::int64_t machine, std::map<std::string, double>, std::string why)> write;
};

class Backups {
 public:
  Backups(db::Store& store, db::Pool& worker, const db::Blobs& blobs, std::filesystem::path data_folder, std::string version);
  ~Backups();
  void set_restorer(Restorer restorer) { restorer_ = std::move(restorer); }

  /// Everything, while the server runs. Refusals: forbidden, backup_running.
  boost::asio::awaitable<db::BackupRow> make_server(access::Actor actor);
  /// Refusals: forbidden, not_found.
  boost::asio::awaitable<db::BackupRow> make_machine(access::Actor actor, std::int64_t machine);
  /// A file that was brought: checked whole before it is kept. Refusals: forbidden, damaged_backup, not_a_backup.
  boost::asio::awaitable<db::BackupRow> keep(access::Actor actor, std::filesystem::path brought);
  /// Refusals: forbidden, not_found.
  boost::asio::awaitable<void> remove(access::Actor actor, std::int64_t id);
  /// Reads it all again. @return its manifest. Refusals: not_found, damaged_backup.
  boost::asio::awaitable<nlohmann::json> verify(std::int64_t id);
  /// To the same machine or another with the same controller. Programs come into the library and, where they are
  /// released, to the machine; values that differ are asked to be written. Refusals: forbidden, not_found,
  /// damaged_backup, not_a_backup, other_profile.
  boost::asio::awaitable<nlohmann::json> restore_machine(access::Actor actor, std::int64_t id, std::int64_t machine);

  std::filesystem::path folder() const { return data_folder_ / "backups"; }
  std::filesystem::path path_of(const db::BackupRow& row) const { return folder() / row.file; }

  /// The backup that is due, and a piece of the retention's work. Does nothing while an earlier call is under way.
  boost::asio::awaitable<void> every_minute();

 private:
  boost::asio::awaitable<void> make_due_backup();
  boost::asio::awaitable<void> thin_out();
  boost::asio::awaitable<db::BackupRow> registered(access::Actor actor, db::BackupRow row);

  db::Store& store_;
  db::Pool& worker_;
  const db::Blobs& blobs_;
  std::filesystem::path data_folder_;
  std::string version_;
  Restorer restorer_;
  bool making_ = false, working_ = false;
};

}  // namespace headstock::backup
