#include "server/dnc/dnc.hpp"

#include <spdlog/spdlog.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/blobs.hpp"
#include "db/program_store.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/access/audit.hpp"
#include "server/dnc/outgoing.hpp"
#include "server/dnc/ports.hpp"
#include "server/dnc/received.hpp"
#include "server/library/programs.hpp"

namespace headstock::dnc {

namespace asio = boost::asio;
using access::Action;
using access::Actor;
using asio::awaitable;

namespace {

std::int64_t ms(serial::Duration time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
}

nlohmann::json figures_of(const serial::SendReport& report) {
  const auto& counters = report.counters;
  nlohmann::json faults = nlohmann::json::object();
  for (std::size_t kind = 0; kind < serial::fault_kinds; ++kind)
    if (counters.faults[kind] > 0)
      faults[std::string(name_of(static_cast<serial::Fault>(kind)))] = counters.faults[kind];
  return {{"blocks", counters.blocks},
          {"stops", counters.stops},
          {"starts", counters.starts},
          {"unexpected", counters.unexpected},
          {"most_after_stop", counters.most_after_stop},
          {"held_ms", ms(counters.held)},
          {"longest_hold_ms", ms(counters.longest_hold)},
          {"starved_ms", ms(counters.starved)},
          {"window", report.window},
          {"faults", std::move(faults)}};
}

struct Job {
  db::PortTransferRow row;
  OutgoingText text;
};

struct Unit {
  db::PortRow row;
  PortSettings settings;
  std::vector<RequestRule> rules;
  PortState now;
  std::optional<Job> job;
  bool starting = false;  ///< a request is between its checks and its job
  std::deque<Job> queue;
  std::unique_ptr<PortLine> line;
  std::int64_t written_ms = 0;
  serial::SendReport last;
  std::shared_ptr<asio::steady_timer> looping;
  serial::LoopReport loop;
};

}  // namespace

struct Dnc::Impl : std::enable_shared_from_this<Impl> {
  Impl(asio::io_context& the_io, db::Store& the_store, db::Pool& the_workers, const db::Blobs& the_blobs,
       library::Checks& the_checks, std::function<void(std::int64_t)> on_change)
      : io(the_io),
        store(the_store),
        workers(the_workers),
        blobs(the_blobs),
        checks(the_checks),
        changed(std::move(on_change)) {}

  Unit& unit(std::int64_t port) {
    const auto found = units.find(port);
    if (found == units.end()) throw db::Refusal("not_found", "port");
    return *found->second;
  }
  static bool busy(const Unit& unit) { return unit.job || unit.starting || unit.looping; }

  // ---- records
  void install(const db::PortRow& row) {
    auto& place = units[row.id];
    const auto kept = place ? std::move(place->queue) : std::deque<Job>();
    place = std::make_unique<Unit>();
    place->row = row;
    place->queue = kept;
    place->settings = settings_from(nlohmann::json::parse(row.settings_json));
    place->rules = rules_from(nlohmann::json::parse(row.rules_json));
    const auto address = serial::address_of(row.address);
    if (!address) return;
    const auto id = row.id;
    PortEvents events;
    events.state = [this, id](PortState now) { on_state(id, std::move(now)); };
    events.sending = [this, id](const serial::SendReport& report) { on_sending(id, report); };
    events.receiving = [this, id](const serial::ReceiveReport& report,
                                  const std::shared_ptr<std::string>& text) {
      on_receiving(id, report, text);
    };
    events.looped = [this, id](const serial::LoopReport& report) {
      Unit& at = unit(id);
      at.loop = report;
      if (at.looping) at.looping->cancel();
    };
    place->line = std::make_unique<PortLine>(lines, io.get_executor(), *address, place->settings, row.listens,
                                             std::move(events));
  }

  // ---- from the lines
  void on_state(std::int64_t port, PortState now) {
    Unit& at = unit(port);
    if (now.state == "failed" && at.now.state != "failed")
      spdlog::warn("port {} ({}): {} {}", at.row.name, at.row.address, now.reason, now.text);
    at.now = std::move(now);
    changed(port);
  }

  void on_sending(std::int64_t port, const serial::SendReport& report) {
    Unit& at = unit(port);
    if (!at.job) return;
    auto& row = at.job->row;
    at.last = report;
    row.state = serial::name_of(report.state);
    row.bytes = static_cast<std::int64_t>(report.counters.bytes);
    row.figures_json = figures_of(report).dump();
    if (!row.started_ms && report.counters.bytes > 0) row.started_ms = db::now_ms();
    if (report.over()) {
      row.reason = report.reason;
      row.detail = report.text;
      end_job(at);
    } else {
      write_sometimes(at);
    }
    changed(port);
  }

  /// Progress is written every five seconds: after a crash it is known how far it had come.
  void write_sometimes(Unit& at) {
    if (db::now_ms() - at.written_ms < 5'000) return;
    at.written_ms = db::now_ms();
    write(at.job->row);
  }
  void write(const db::PortTransferRow& row) {
    store.post("a transfer over a port", [row](db::Database& db) { db::update_port_transfer(db, row); });
  }

  void end_job(Unit& at) {
    auto row = at.job->row;
    row.ended_ms = db::now_ms();
    // The hash of what was to be sent is the hash of what was sent only when all of it was.
    if (row.state != "done") row.wire_sha256.clear();
    write(row);
    spdlog::info("port {}: {} {} {}, {} of {} characters{}{}", at.row.name, row.kind, row.name, row.state,
                 row.bytes, row.total, row.reason.empty() ? "" : ", ", row.reason);
    at.job.reset();
    if (row.state == "done" && !at.queue.empty()) {
      auto next = std::move(at.queue.front());
      at.queue.pop_front();
      start_job(at, std::move(next));
    }
  }

  void start_job(Unit& at, Job job) {
    job.row.state = "waiting";
    write(job.row);
    auto source = outgoing(job.text, at.settings);
    at.job = std::move(job);
    at.last = {};
    at.line->send(std::move(source));
  }

  void on_receiving(std::int64_t port, const serial::ReceiveReport& report,
                    const std::shared_ptr<std::string>& text) {
    Unit& at = unit(port);
    const bool empty = report.bytes == 0;
    // A punch that came while a request was being looked through is kept as well.
    if (!at.job && !empty && (!at.starting || report.over())) begin_receiving(at, "control");
    if (!at.job) return;
    auto& row = at.job->row;
    if (row.id != 0 && row.kind != "receive") return;
    row.state = serial::name_of(report.state);
    row.bytes = static_cast<std::int64_t>(report.bytes);
    if (!row.started_ms && !empty) row.started_ms = db::now_ms();
    if (!report.over()) return changed(port);
    row.reason = report.reason;
    row.detail = report.text;
    const auto finished = std::exchange(at.job, std::nullopt)->row;
    at.starting = true;  // nothing else begins before this punch is put away
    asio::co_spawn(
        io,
        [self = shared_from_this(), port, finished, text, closed = report.closed]() -> awaitable<void> {
          co_await self->put_away(port, finished, text, closed);
        },
        [self = shared_from_this(), port](std::exception_ptr error) {
          const auto found = self->units.find(port);
          if (found != self->units.end()) found->second->starting = false;
          if (error) spdlog::error("a punch could not be put away");
          self->changed(port);
        });
  }

  void begin_receiving(Unit& at, const std::string& by) {
    Job job;
    job.row.port = at.row.id;
    job.row.kind = "receive";
    job.row.state = "waiting";
    job.row.by = by;
    job.row.created_ms = db::now_ms();
    at.job = std::move(job);  // its record is written with its end: noise leaves none
  }

  awaitable<void> put_away(std::int64_t port, db::PortTransferRow row, std::shared_ptr<std::string> text,
                           bool closed) {
    const db::PortRow port_row = unit(port).row;
    const PortSettings settings = unit(port).settings;
    Punch punch;
    if (row.state == "done") {
      const auto apart = [this, &text, closed, &settings, &port_row] {
        return take_apart(*text, closed, settings, port_row, blobs);
      };
      try {
        punch = co_await workers.run(apart);
      } catch (const std::exception& error) {
        punch.reason = "not_kept";
        punch.where = error.what();
      }
      if (!punch.reason.empty()) {
        row.state = "failed";
        row.reason = punch.reason;
        row.detail = punch.where;
      }
    }
    const auto asked = row.state == "done" ? wanted(punch.text, unit(port).rules) : Wanted{};
    row.ended_ms = db::now_ms();
    row.name = asked.rule != nullptr ? asked.name : punch.pieces.empty() ? "" : punch.pieces.front().row.name;
    row.total = row.bytes;
    const auto put = [this, &row, &punch, &port_row, asked](db::Database& db) {
      db::Transaction transaction(db);
      row.id = db::insert_port_transfer(db, row);
      db::update_port_transfer(db, row);
      if (row.state == "done" && asked.rule == nullptr)
        keep(db, blobs, std::move(punch), port_row, row.id, db::now_ms());
      transaction.commit();
    };
    co_await store.run(put);
    spdlog::info("port {}: received {} characters, {}{}{}", port_row.name, row.bytes, row.state,
                 row.reason.empty() ? "" : ", ", row.reason);
    if (asked.rule == nullptr) co_return;
    const RequestRule rule = *asked.rule;
    const std::string name = asked.name;
    co_await answer(port, rule, name);
  }

  /// The control has asked for a program, or for the list.
  awaitable<void> answer(std::int64_t port, RequestRule rule, std::string name) {
    Unit& at = unit(port);
    Job job;
    job.row.port = port;
    job.row.kind = "answer";
    job.row.state = "waiting";
    job.row.name = name;
    job.row.by = "control";
    job.row.created_ms = db::now_ms();
    std::string reason;
    const std::string folder = at.row.folder;
    if (rule.action == RequestRule::list) {
      const auto list = [folder](db::Database& db) {
        db::ProgramFilter filter;
        filter.folder = folder;
        return db::programs(db, filter, {0, 1000}).items;
      };
      const auto programs = co_await store.run(list);
      job.text.header =
          std::string("%\n").append(rule.name.empty() ? "O9999" : rule.name).append("(PROGRAMS)\n");
      for (const auto& program : programs)
        if (program.released) job.text.header.append("(").append(program.name).append(")\n");
      job.text.header.append("M30\n%\n");
    } else {
      const auto look = [folder, name](db::Database& db) { return db::program_named(db, folder, name); };
      const auto program = co_await store.run(look);
      if (!program)
        reason = "not_found";
      else if (!program->released)
        reason = "not_released";
      if (reason.empty()) {
        job.row.program = program->id;
        job.row.revision = program->released->number;
        job.row.sha256 = program->released->blob.sha256;
        job.text.file = blobs.path(job.row.sha256).string();
      }
    }
    if (reason.empty()) {
      const OutgoingFacts facts = co_await looked_through(job.text, unit(port).settings);
      reason = facts.reason;
      job.row.detail = facts.where;
      job.row.total = static_cast<std::int64_t>(facts.bytes);
      job.row.wire_sha256 = facts.sha256;
    }
    if (!reason.empty()) {
      job.row.state = "failed";
      job.row.reason = reason;
      job.row.ended_ms = db::now_ms();
    }
    const auto put = [&job](db::Database& db) {
      job.row.id = db::insert_port_transfer(db, job.row);
      if (job.row.ended_ms) db::update_port_transfer(db, job.row);
    };
    co_await store.run(put);
    Unit& now = unit(port);
    if (reason.empty()) start_job(now, std::move(job));
    changed(port);
  }

  awaitable<OutgoingFacts> looked_through(OutgoingText text, PortSettings settings) {
    const auto look = [&text, &settings] { return examine(text, settings); };
    co_return co_await workers.run(look);
  }

  asio::io_context& io;
  db::Store& store;
  db::Pool& workers;
  const db::Blobs& blobs;
  library::Checks& checks;
  std::function<void(std::int64_t)> changed;
  LineThread lines;
  std::map<std::int64_t, std::unique_ptr<Unit>> units;
};

Dnc::Dnc(asio::io_context& io, db::Store& store, db::Pool& workers, const db::Blobs& blobs,
         library::Checks& checks, std::function<void(std::int64_t)> changed)
    : impl_(std::make_shared<Impl>(io, store, workers, blobs, checks, std::move(changed))) {}

Dnc::~Dnc() {
  impl_->units.clear();
}

awaitable<void> Dnc::start() {
  const auto read = [](db::Database& db) {
    db::end_open_port_transfers(db, "server_restarted", db::now_ms());
    return db::ports(db);
  };
  for (const auto& row : co_await impl_->store.run(read)) impl_->install(row);
}

void Dnc::stop() {
  for (auto& [id, unit] : impl_->units) {
    if (unit->job && unit->job->row.id != 0) {
      auto row = unit->job->row;
      row.state = "failed";
      row.reason = "server_stopped";
      row.ended_ms = db::now_ms();
      row.wire_sha256.clear();
      impl_->write(row);
    }
    unit->job.reset();
    unit->line.reset();
  }
}

namespace {

PortView view_of(const Unit& unit) {
  PortView view;
  view.row = unit.row;
  view.now = unit.now;
  if (unit.job) view.transfer = unit.job->row;
  for (const auto& job : unit.queue) view.queue.push_back(job.row);
  view.window = unit.last.window;
  view.most_after_stop = unit.last.counters.most_after_stop;
  view.stops = unit.last.counters.stops;
  view.starved_ms = ms(unit.last.counters.starved);
  view.longest_hold_ms = ms(unit.last.counters.longest_hold);
  return view;
}

}  // namespace

std::vector<PortView> Dnc::views() const {
  std::vector<PortView> views;
  for (const auto& [id, unit] : impl_->units) views.push_back(view_of(*unit));
  return views;
}

PortView Dnc::view(std::int64_t port) const {
  return view_of(impl_->unit(port));
}

awaitable<db::PortRow> Dnc::create(Actor actor, nlohmann::json fields) {
  const auto make = [&](db::Database& db) { return create_port(db, actor, fields, db::now_ms()); };
  const auto row = co_await impl_->store.run(make);
  impl_->install(row);
  impl_->changed(row.id);
  co_return row;
}

awaitable<db::PortRow> Dnc::change(Actor actor, std::int64_t port, nlohmann::json fields) {
  if (Impl::busy(impl_->unit(port))) throw db::Refusal("port_busy");
  const auto make = [&](db::Database& db) { return change_port(db, actor, port, fields, db::now_ms()); };
  const auto row = co_await impl_->store.run(make);
  impl_->install(row);
  impl_->changed(port);
  co_return row;
}

awaitable<void> Dnc::remove(Actor actor, std::int64_t port) {
  if (Impl::busy(impl_->unit(port))) throw db::Refusal("port_busy");
  const auto make = [&](db::Database& db) { remove_port(db, actor, port, db::now_ms()); };
  co_await impl_->store.run(make);
  impl_->units.erase(port);
  impl_->changed(port);
}

awaitable<db::PortTransferRow> Dnc::send(Actor actor, std::int64_t port, SendWish wish) {
  access::demand(actor, Action::open_drip);
  auto& impl = *impl_;
  Unit& at = impl.unit(port);
  const bool later = Impl::busy(at);
  if (later && !wish.queue) throw db::Refusal("port_busy");
  const auto* protocol = serial::protocol_named(at.settings.link.protocol);
  if (later && !(protocol != nullptr && protocol->wait_for_start)) throw db::Refusal("cannot_queue");
  if (later && at.queue.size() >= 100) throw db::Refusal("port_busy");
  if (wish.from_line > 1 && wish.header.find_first_not_of(" \r\n\t") == std::string::npos)
    throw db::Refusal("header_missing");
  struct Free {
    Impl& impl;
    std::int64_t port;
    bool armed;
    ~Free() {
      const auto found = impl.units.find(port);
      if (armed && found != impl.units.end()) found->second->starting = false;
    }
  } free{impl, port, !later};
  at.starting = at.starting || !later;
  const auto look = [wish](db::Database& db) {
    const auto program = library::require_program(db, wish.program);
    const auto revision = library::require_revision(db, wish.program, wish.revision);
    if (!revision.released) throw db::Refusal("not_released");
    return std::pair(program, revision);
  };
  const auto [program, revision] = co_await impl.store.run(look);
  Job job;
  job.text.file = impl.blobs.path(revision.blob.sha256).string();
  if (wish.from_line > 1) {
    const auto restart = co_await this->restart(port, wish.program, wish.revision, wish.from_line);
    // Where a line begins does not depend on whether plain blocks could bring the state back; a person who
    // has written a header himself answers for it only when the program could be followed that far.
    if (!restart.reason.empty()) throw db::Refusal(restart.reason, restart.where);
    job.text.offset = restart.offset;
    job.text.header = wish.header.ends_with('\n') ? wish.header : wish.header + "\n";
  }
  const OutgoingFacts facts = co_await impl.looked_through(job.text, impl.unit(port).settings);
  if (!facts.reason.empty()) throw db::Refusal(facts.reason, facts.where);
  job.row.port = port;
  job.row.kind = wish.drip ? "drip" : "send";
  job.row.state = "queued";
  job.row.program = program.id;
  job.row.revision = revision.number;
  job.row.name = program.name;
  job.row.sha256 = revision.blob.sha256;
  job.row.from_line = wish.from_line;
  job.row.header = wish.from_line > 1 ? job.text.header : "";
  job.row.total = static_cast<std::int64_t>(facts.bytes);
  job.row.wire_sha256 = facts.sha256;
  job.row.by = actor.user;
  job.row.created_ms = db::now_ms();
  const auto put = [&](db::Database& db) {
    db::Transaction transaction(db);
    job.row.id = db::insert_port_transfer(db, job.row);
    access::record(db, actor, "port.send", std::string("port:").append(std::to_string(port)),
                   {{"program", program.name},
                    {"revision", std::to_string(revision.number)},
                    {"from_line", std::to_string(wish.from_line)},
                    {"header", job.row.header}});
    transaction.commit();
  };
  co_await impl.store.run(put);
  Unit& now = impl.unit(port);
  const auto row = job.row;
  if (later && (now.job || now.starting)) {
    now.queue.push_back(std::move(job));
  } else {
    impl.start_job(now, std::move(job));
  }
  impl.changed(port);
  co_return row;
}

awaitable<library::Restart> Dnc::restart(std::int64_t port, std::int64_t program, std::int64_t revision,
                                         std::int64_t line) {
  const auto machine = impl_->unit(port).row.machine;
  if (machine == 0) throw db::Refusal("no_machine");
  co_return co_await impl_->checks.restart(program, revision, machine, line);
}

awaitable<db::PortTransferRow> Dnc::receive(Actor actor, std::int64_t port) {
  access::demand(actor, Action::open_drip);
  Unit& at = impl_->unit(port);
  if (Impl::busy(at)) throw db::Refusal("port_busy");
  impl_->begin_receiving(at, actor.user);
  at.line->receive();
  impl_->changed(port);
  co_return at.job->row;
}

void Dnc::pause(const Actor& actor, std::int64_t port) {
  access::demand(actor, Action::cancel_transfer);
  Unit& at = impl_->unit(port);
  if (!at.job || at.job->row.kind == "receive") throw db::Refusal("nothing_under_way");
  at.line->pause();
}

void Dnc::resume(const Actor& actor, std::int64_t port) {
  access::demand(actor, Action::open_drip);
  Unit& at = impl_->unit(port);
  if (!at.job || at.job->row.kind == "receive") throw db::Refusal("nothing_under_way");
  at.line->resume();
}

void Dnc::cancel(const Actor& actor, std::int64_t port) {
  access::demand(actor, Action::cancel_transfer);
  Unit& at = impl_->unit(port);
  if (!at.job && !at.looping) throw db::Refusal("nothing_under_way");
  at.line->cancel("cancelled");
}

void Dnc::unqueue(const Actor& actor, std::int64_t port, std::int64_t transfer) {
  access::demand(actor, Action::cancel_transfer);
  auto& queue = impl_->unit(port).queue;
  const auto found =
      std::find_if(queue.begin(), queue.end(), [&](const Job& job) { return job.row.id == transfer; });
  if (found == queue.end()) throw db::Refusal("not_found", "transfer");
  auto row = found->row;
  queue.erase(found);
  row.state = row.reason = "cancelled";
  row.ended_ms = db::now_ms();
  row.wire_sha256.clear();
  impl_->write(row);
  impl_->changed(port);
}

awaitable<serial::LoopReport> Dnc::loop_test(Actor actor, std::int64_t port, std::size_t characters) {
  access::demand(actor, Action::edit_machine);
  Unit& at = impl_->unit(port);
  if (Impl::busy(at)) throw db::Refusal("port_busy");
  const auto timer = std::make_shared<asio::steady_timer>(impl_->io, asio::steady_timer::time_point::max());
  at.looping = timer;
  at.line->loop_test(characters);
  boost::system::error_code woken;
  co_await timer->async_wait(asio::redirect_error(asio::use_awaitable, woken));
  Unit& now = impl_->unit(port);
  now.looping.reset();
  co_return now.loop;
}

awaitable<MonitorPiece> Dnc::monitor(std::int64_t port, std::uint64_t after, std::size_t most) {
  Unit& at = impl_->unit(port);
  if (!at.line) co_return MonitorPiece{};
  co_return co_await at.line->monitor(after, most);
}

}  // namespace headstock::dnc
