#include "server/library/distribution.hpp"

#include <algorithm>
#include <chrono>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <map>
#include <set>

#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "protocol/process/log.hpp"
#include "server/access/audit.hpp"
#include "server/library/checks.hpp"
#include "server/library/programs.hpp"
#include "server/library/request.hpp"

namespace headstock::library {

namespace asio = boost::asio;
using access::Action;
using access::Actor;
using access::demand;

namespace {

class StoredText final : public server::BlobReader {
 public:
  explicit StoredText(std::shared_ptr<db::Blobs::Reader> reader) : reader_(std::move(reader)) {}
  std::uint64_t size() const override { return reader_->size(); }
  std::size_t read(std::uint64_t offset, char* into, std::size_t at_most) override {
    return reader_->read(offset, into, at_most);
  }

 private:
  std::shared_ptr<db::Blobs::Reader> reader_;
};

constexpr int kRequestAttempts = 50;
constexpr std::chrono::milliseconds kRequestPause{20};

bool is_over(const std::string& state) {
  return state == "done" || state == "failed" || state == "cancelled";
}

db::TransferRow new_transfer(const Actor& actor, const db::ProgramRow& program,
                             const db::RevisionRow& revision, std::int64_t machine, const char* kind,
                             std::int64_t now_ms) {
  db::TransferRow row;
  row.machine = machine;
  row.program = program.id;
  row.revision = revision.number;
  row.name = program.name;
  row.sha256 = revision.blob.sha256;
  row.kind = kind;
  row.state = "queued";
  row.total = revision.blob.bytes;
  row.by = actor.user;
  row.created_ms = now_ms;
  return row;
}

void end(db::TransferRow& row, const char* state, std::string reason) {
  row.state = state;
  row.reason = std::move(reason);
  row.ended_ms = db::now_ms();
}

}  // namespace

std::shared_ptr<server::BlobReader> blob_reader(const db::Blobs& blobs, const std::string& sha256) {
  return std::make_shared<StoredText>(blobs.open(sha256));
}

struct Distributor::Impl : std::enable_shared_from_this<Distributor::Impl> {
  Impl(asio::any_io_executor the_network, db::Store& the_store, const db::Blobs& the_blobs,
       Checks& the_checks, Carrier the_carrier, Changed on_change)
      : network(std::move(the_network)),
        store(the_store),
        blobs(the_blobs),
        checks(the_checks),
        carrier(std::move(the_carrier)),
        changed(std::move(on_change)) {}

  /// The newest state: kept here while the transfer is open, written when it changes, not with every byte.
  void remember(const db::TransferRow& row) {
    const auto before = open.find(row.id);
    const bool write = before == open.end() || before->second.state != row.state ||
                       before->second.reason != row.reason || is_over(row.state);
    if (is_over(row.state))
      open.erase(row.id);
    else
      open[row.id] = row;
    if (write) store.post("transfer", [row](db::Database& db) { db::update_transfer(db, row); });
    if (changed) changed(row);
  }

  /// @return the row while it is still open: a cancelled one must not come back to life.
  db::TransferRow* find_open(std::int64_t id) {
    const auto found = open.find(id);
    return found == open.end() ? nullptr : &found->second;
  }

  void fail(std::int64_t id, const std::string& reason) {
    if (const db::TransferRow* row = find_open(id)) {
      db::TransferRow copy = *row;
      end(copy, "failed", reason);
      remember(copy);
    }
  }

  void move_to(std::int64_t id, const char* state) {
    if (const db::TransferRow* row = find_open(id)) {
      db::TransferRow copy = *row;
      copy.state = state;
      if (!copy.started_ms) copy.started_ms = db::now_ms();
      remember(copy);
    }
  }

  void take(const server::TransferState& state) {
    const db::TransferRow* row = find_open(static_cast<std::int64_t>(state.id));
    if (row == nullptr) return;
    db::TransferRow copy = *row;
    copy.bytes = static_cast<std::int64_t>(state.bytes);
    copy.reason = state.reason;
    copy.state = state.state;
    if (!copy.started_ms) copy.started_ms = db::now_ms();
    if (is_over(copy.state)) copy.ended_ms = db::now_ms();
    remember(copy);
  }

  /// Everything that can be said before bytes flow. @return the reason against it, or empty.
  asio::awaitable<std::string> reason_against(db::TransferRow row) {
    if (!carrier.is_connected(row.machine)) co_return "not_connected";
    const Actor server;
    const CheckResult check = co_await checks.check(server, row.program, row.revision, row.machine);
    co_return check.ok ? "" : "check_failed";
  }

  asio::awaitable<void> put(db::TransferRow row) {
    std::string reason;
    try {
      move_to(row.id, "checking");
      reason = co_await reason_against(row);
      if (reason.empty() && find_open(row.id) != nullptr) {
        move_to(row.id, "sending");
        take(co_await carrier.put(static_cast<std::uint64_t>(row.id), row.machine, row.name, row.sha256,
                                  blob_reader(blobs, row.sha256)));
        co_return;
      }
    } catch (const db::Refusal& refusal) {
      reason = refusal.code();
    } catch (const std::exception& error) {
      log::error("transfer {}: {}", row.id, error.what());
      reason = "internal";
    }
    fail(row.id, reason);
  }

  asio::awaitable<server::MachineAnswer> offer(db::TransferRow row) {
    co_return co_await carrier.drip(static_cast<std::uint64_t>(row.id), row.machine, row.name, row.sha256,
                                    blob_reader(blobs, row.sha256));
  }

  template <class Work>
  void spawn(Work work) {
    asio::co_spawn(
        network, [self = shared_from_this(), work]() -> asio::awaitable<void> { co_await work(*self); },
        asio::detached);
  }

  asio::any_io_executor network;
  db::Store& store;
  const db::Blobs& blobs;
  Checks& checks;
  Carrier carrier;
  Changed changed;
  std::map<std::int64_t, db::TransferRow> open;
  std::set<std::int64_t> opening;  // machines whose drip-feed is being prepared
};

Distributor::Distributor(asio::any_io_executor network, db::Store& store, const db::Blobs& blobs,
                         Checks& checks, Carrier carrier, Changed changed)
    : impl_(std::make_shared<Impl>(std::move(network), store, blobs, checks, std::move(carrier),
                                   std::move(changed))) {}

Distributor::~Distributor() = default;

asio::awaitable<void> Distributor::resume() {
  const auto rows = co_await impl_->store.run([](db::Database& db) {
    db::Transaction transaction(db);
    db::TransferFilter filter;
    filter.open_only = true;
    auto open_ones = db::transfers(db, filter, {0, 1000}).items;
    for (db::TransferRow& row : open_ones) {
      if (row.kind == "drip")
        row.state = "waiting";
      else
        end(row, "failed", "server_restarted");
      db::update_transfer(db, row);
    }
    transaction.commit();
    return open_ones;
  });
  for (const db::TransferRow& row : rows) {
    if (is_over(row.state)) continue;
    impl_->open[row.id] = row;
    impl_->carrier.offer_again(static_cast<std::uint64_t>(row.id), row.machine, row.name, row.sha256,
                               blob_reader(impl_->blobs, row.sha256));
  }
}

asio::awaitable<db::DistributionRow> Distributor::distribute(Actor actor, std::int64_t program,
                                                             std::int64_t revision,
                                                             std::vector<std::int64_t> machines) {
  demand(actor, Action::send_program);
  if (machines.empty()) throw db::Refusal("no_machines");
  std::ranges::sort(machines);
  machines.erase(std::unique(machines.begin(), machines.end()), machines.end());
  const auto impl = impl_;
  const auto make_plan = [=](db::Database& db) {
    db::Transaction transaction(db);
    const db::ProgramRow what = require_program(db, program);
    const db::RevisionRow which = require_revision(db, program, revision);
    const std::int64_t now = db::now_ms();
    db::DistributionRow row;
    row.program = program;
    row.revision = revision;
    row.at_ms = now;
    row.by = actor.user;
    for (const std::int64_t machine : machines)
      if (!db.integer("SELECT 1 FROM machines WHERE id = ?", {machine}))
        throw db::Refusal("not_found", std::string("machine:").append(std::to_string(machine)));
    row.id = db::insert_distribution(db, row);
    for (const std::int64_t machine : machines) {
      db::TransferRow transfer = new_transfer(actor, what, which, machine, "put", now);
      transfer.distribution = row.id;
      if (!which.released)
        end(transfer, "failed", "not_released");
      else if (!db::machine(db, machine))
        end(transfer, "failed", "machine_removed");
      transfer.id = db::insert_transfer(db, transfer);
      row.transfers.push_back(transfer);
    }
    record(db, actor, "program.send", std::string("program:").append(std::to_string(program)),
           {{"revision", std::to_string(revision)},
            {"machines", std::to_string(machines.size())},
            {"distribution", std::to_string(row.id)}});
    transaction.commit();
    return row;
  };
  db::DistributionRow plan = co_await impl->store.run(make_plan);
  for (db::TransferRow& row : plan.transfers) {
    if (!is_over(row.state)) {
      impl->open[row.id] = row;
      if (!impl->carrier.is_connected(row.machine)) {
        impl->fail(row.id, "not_connected");
        end(row, "failed", "not_connected");
        continue;
      }
      impl->spawn([row](Impl& self) { return self.put(row); });
    }
    if (impl->changed) impl->changed(row);
  }
  co_return plan;
}

asio::awaitable<db::TransferRow> Distributor::drip(Actor actor, std::int64_t machine, std::int64_t program,
                                                   std::int64_t revision) {
  demand(actor, Action::open_drip);
  const auto impl = impl_;
  const auto prepare = [=](db::Database& db) {
    if (!db::machine(db, machine))
      throw db::Refusal("not_found", std::string("machine:").append(std::to_string(machine)));
    const db::RevisionRow which = require_revision(db, program, revision);
    if (!which.released) throw db::Refusal("not_released");
    return new_transfer(actor, require_program(db, program), which, machine, "drip", db::now_ms());
  };
  db::TransferRow row = co_await impl->store.run(prepare);
  const bool open_already = std::ranges::any_of(impl->open, [&](const auto& entry) {
    return entry.second.kind == "drip" && entry.second.machine == machine;
  });
  if (open_already || !impl->opening.insert(machine).second) throw db::Refusal("drip_open");
  struct Opened {
    Impl& impl;
    std::int64_t machine;
    ~Opened() { impl.opening.erase(machine); }
  } opened{*impl, machine};
  if (const std::string reason = co_await impl->reason_against(row); !reason.empty())
    throw db::Refusal(reason);
  row.started_ms = db::now_ms();
  row.state = "sending";
  const auto insert = [=](db::Database& db) {
    db::Transaction transaction(db);
    const std::int64_t id = db::insert_transfer(db, row);
    record(db, actor, "drip.open", access::subject("transfer", id),
           {{"machine", std::to_string(machine)},
            {"program", std::to_string(program)},
            {"revision", std::to_string(revision)}});
    transaction.commit();
    return id;
  };
  row.id = co_await impl->store.run(insert);
  impl->open[row.id] = row;
  const server::MachineAnswer answer = co_await impl->offer(row);
  if (!answer.accepted) {
    impl->fail(row.id, answer.reason);
    throw db::Refusal("machine_refused", answer.reason);
  }
  if (const db::TransferRow* now = impl->find_open(row.id)) row = *now;
  if (impl->changed) impl->changed(row);
  co_return row;
}

asio::awaitable<server::MachineAnswer> Distributor::requested(std::int64_t machine, std::string name) {
  const auto look = [name](db::Database& db) { return find_requested(db, name); };
  const RequestedProgram found = co_await impl_->store.run(look);
  if (!found.reason.empty()) co_return server::MachineAnswer{false, found.reason};
  Actor actor;
  actor.user = std::string("machine:").append(std::to_string(machine));
  actor.role = access::Role::operator_;
  asio::steady_timer timer(impl_->network);
  for (int attempt = 1;; ++attempt) {
    try {
      co_await drip(actor, machine, found.program, found.revision);
      co_return server::MachineAnswer{true, ""};
    } catch (const db::Refusal& refusal) {
      // A sub-program called again and again: the machine may ask before the word that the last one is over.
      if (refusal.code() != "drip_open" || attempt == kRequestAttempts)
        co_return server::MachineAnswer{false, std::string(refusal.code())};
    }
    timer.expires_after(kRequestPause);
    co_await timer.async_wait(asio::use_awaitable);
  }
}

asio::awaitable<db::TransferRow> Distributor::cancel(Actor actor, std::int64_t transfer) {
  demand(actor, Action::cancel_transfer);
  const auto impl = impl_;
  const auto row = co_await find(transfer);
  if (!row) throw db::Refusal("not_found", access::subject("transfer", transfer));
  if (is_over(row->state)) throw db::Refusal("transfer_over", row->state);
  const auto note = [=](db::Database& db) { record(db, actor, "transfer.cancel", access::subject("transfer", transfer)); };
  co_await impl->store.run(note);
  db::TransferRow copy = *row;
  if (const db::TransferRow* now = impl->find_open(transfer)) copy = *now;
  end(copy, "cancelled", "cancelled_by_user");
  impl->remember(copy);
  impl->carrier.cancel(static_cast<std::uint64_t>(transfer), "cancelled_by_user");
  co_return copy;
}

asio::awaitable<std::optional<db::TransferRow>> Distributor::find(std::int64_t transfer) {
  const auto impl = impl_;
  if (const db::TransferRow* row = impl->find_open(transfer)) co_return *row;
  const auto read = [transfer](db::Database& db) { return db::transfer(db, transfer); };
  co_return co_await impl->store.run(read);
}

asio::awaitable<db::Listed<db::TransferRow>> Distributor::list(db::TransferFilter filter, db::Page page) {
  const auto impl = impl_;
  const auto read = [=](db::Database& db) { return db::transfers(db, filter, page); };
  auto rows = co_await impl->store.run(read);
  for (db::TransferRow& row : rows.items)
    if (const db::TransferRow* now = impl->find_open(row.id)) row = *now;
  co_return rows;
}

void Distributor::transfer_changed(const server::TransferState& state) {
  impl_->take(state);
}

}  // namespace headstock::library
