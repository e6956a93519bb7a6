#include "server/library/checks.hpp"

#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "db/hash.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/library/programs.hpp"

namespace headstock::library {

namespace asio = boost::asio;

namespace {

/// What a job needs from the store, read in one go.
struct Prepared {
  CheckJob job;
  db::RevisionRow revision;
  std::optional<db::CheckRow> known;
};

/// Programs of the same folder that this one may call: their released revision, otherwise the newest.
std::map<std::string, std::string> neighbours(db::Database& db, const db::Blobs& blobs,
                                              const db::ProgramRow& program) {
  std::map<std::string, std::string> found;
  db::ProgramFilter filter;
  filter.folder = program.folder;
  for (const db::ProgramRow& row : db::programs(db, filter, {0, 1000}).items) {
    const auto& revision = row.released ? row.released : row.newest;
    if (revision && row.id != program.id) found[row.name] = blobs.path(revision->blob.sha256).string();
  }
  return found;
}

/// A program that calls others depends on them: their contents are part of the key.
std::string checker_for(const CheckJob& job) {
  if (job.subprograms.empty()) return checker_version();
  std::string names;
  for (const auto& [name, file] : job.subprograms) names += name + "=" + file + ";";
  return checker_version() + "+" + db::sha256_hex(names).substr(0, 16);
}

Prepared prepare(db::Database& db, const db::Blobs& blobs, std::int64_t program, std::int64_t revision,
                 std::int64_t machine) {
  Prepared prepared;
  prepared.revision = require_revision(db, program, revision);
  prepared.job.file = blobs.path(prepared.revision.blob.sha256).string();
  prepared.job.subprograms = neighbours(db, blobs, require_program(db, program));
  if (machine == 0) return prepared;
  const auto row = db::machine(db, machine);
  if (!row) throw db::Refusal("not_found", std::string("machine:").append(std::to_string(machine)));
  prepared.job.machine = *row;
  prepared.job.settings = db::offsets(db, machine);
  prepared.known = db::find_check(db, prepared.revision.blob.sha256, machine, row->config_hash,
                                  row->offsets_version, checker_for(prepared.job));
  return prepared;
}

}  // namespace

struct Checks::Impl {
  Impl(db::Store& the_store, db::Pool& the_workers, const db::Blobs& the_blobs)
      : store(the_store), workers(the_workers), blobs(the_blobs) {}

  asio::awaitable<Prepared> read(std::int64_t program, std::int64_t revision, std::int64_t machine) {
    const auto in_store = [this, program, revision, machine](db::Database& db) {
      return prepare(db, blobs, program, revision, machine);
    };
    co_return co_await store.run(in_store);
  }

  db::Store& store;
  db::Pool& workers;
  const db::Blobs& blobs;
  std::shared_ptr<std::atomic<bool>> stop = std::make_shared<std::atomic<bool>>(false);
  std::map<std::string, std::shared_ptr<asio::steady_timer>>
      running;  // network thread only; the timer wakes who waits
};

Checks::Checks(db::Store& store, db::Pool& workers, const db::Blobs& blobs)
    : impl_(std::make_unique<Impl>(store, workers, blobs)) {}

Checks::~Checks() {
  *impl_->stop = true;
}

asio::awaitable<CheckResult> Checks::check(access::Actor actor, std::int64_t program, std::int64_t revision,
                                           std::int64_t machine) {
  demand(actor, access::Action::check_program);
  if (machine == 0) throw db::Refusal("not_found", "machine:0");
  for (;;) {
    Prepared prepared = co_await impl_->read(program, revision, machine);
    if (prepared.known) co_return check_result_from_json(nlohmann::json::parse(prepared.known->result_json));
    db::CheckRow row;
    row.sha256 = prepared.revision.blob.sha256;
    row.machine = machine;
    row.config_hash = prepared.job.machine.config_hash;
    row.offsets_version = prepared.job.machine.offsets_version;
    row.checker = checker_for(prepared.job);
    const std::string key = row.sha256 + "/" + std::to_string(machine) + "/" + row.config_hash + "/" +
                            std::to_string(row.offsets_version) + row.checker;
    if (const auto other = impl_->running.find(key); other != impl_->running.end()) {
      const auto timer = other->second;  // the same check is under way: its result will be in the store
      boost::system::error_code woken;
      co_await timer->async_wait(asio::redirect_error(asio::use_awaitable, woken));
      continue;
    }
    const auto timer = std::make_shared<asio::steady_timer>(co_await asio::this_coro::executor,
                                                            asio::steady_timer::time_point::max());
    impl_->running.emplace(key, timer);
    struct Done {
      Impl& impl;
      const std::string& key;
      ~Done() {
        const auto found = impl.running.find(key);
        found->second->cancel();
        impl.running.erase(found);
      }
    } done{*impl_, key};
    auto on_worker = [job = std::move(prepared.job), stop = impl_->stop]() mutable {
      job.cancel = stop.get();
      return run_check(job);
    };
    CheckResult result = co_await impl_->workers.run(on_worker);
    if (*impl_->stop) throw db::Refusal("cancelled");
    result.machine = machine;
    result.at_ms = db::now_ms();
    row.ok = result.ok;
    row.result_json = to_json(result).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    row.at_ms = result.at_ms;
    const auto in_store = [row](db::Database& db) { db::put_check(db, row); };
    co_await impl_->store.run(in_store);
    co_return result;
  }
}

asio::awaitable<std::optional<CheckResult>> Checks::known(std::int64_t program, std::int64_t revision,
                                                          std::int64_t machine) {
  const Prepared prepared = co_await impl_->read(program, revision, machine);
  if (!prepared.known) co_return std::nullopt;
  co_return check_result_from_json(nlohmann::json::parse(prepared.known->result_json));
}

asio::awaitable<Restart> Checks::restart(std::int64_t program, std::int64_t revision, std::int64_t machine,
                                         std::int64_t line) {
  Prepared prepared = co_await impl_->read(program, revision, machine);
  auto on_worker = [job = std::move(prepared.job), stop = impl_->stop, line]() mutable {
    job.cancel = stop.get();
    return run_restart(job, line);
  };
  co_return co_await impl_->workers.run(on_worker);
}

asio::awaitable<Backplot> Checks::backplot(std::int64_t program, std::int64_t revision, std::int64_t machine,
                                           std::string profile, std::int64_t max_points) {
  Prepared prepared = co_await impl_->read(program, revision, machine);
  if (machine == 0) prepared.job.machine.profile = std::move(profile);
  auto on_worker = [job = std::move(prepared.job), stop = impl_->stop, max_points]() mutable {
    job.cancel = stop.get();
    return run_backplot(job, max_points);
  };
  co_return co_await impl_->workers.run(on_worker);
}

}  // namespace headstock::library
