// What goes out: a wish is looked through, becomes a job, and its end a certificate.

#include <boost/asio/use_awaitable.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/blobs.hpp"
#include "db/machine_store.hpp"
#include "db/program_store.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "protocol/process/log.hpp"
#include "server/access/audit.hpp"
#include "server/dnc/service.hpp"
#include "server/library/programs.hpp"

namespace headstock::dnc {

using access::Action;
using access::Actor;
using boost::asio::awaitable;

namespace {

constexpr std::size_t kLongestQueue = 100;

std::int64_t whole_us(serial::Duration time) {
  return std::chrono::duration_cast<std::chrono::microseconds>(time).count();
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
          {"longest_stop_us", whole_us(counters.longest_stop)},
          {"held_ms", whole_ms(counters.held)},
          {"longest_hold_ms", whole_ms(counters.longest_hold)},
          {"starved_ms", whole_ms(counters.starved)},
          {"sending_ms", whole_ms(counters.sending)},
          {"window", report.window},
          {"faults", std::move(faults)}};
}

bool asks_first(const PortSettings& settings) {
  const auto* protocol = serial::protocol_named(settings.link.protocol);
  return protocol != nullptr && protocol->wait_for_start;
}

}  // namespace

std::int64_t whole_ms(serial::Duration time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
}

void Dnc::Impl::on_sending(std::int64_t port, const serial::SendReport& report) {
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
    measure(at);
    end_job(at);
  } else {
    write_sometimes(at);
  }
  changed(port);
}

void Dnc::Impl::measure(Unit& at) {
  const auto& counters = at.last.counters;
  if (counters.bytes == 0) return;
  auto& sum = at.measured;
  sum.port = at.row.id;
  ++sum.transfers;
  sum.stops += counters.stops;
  sum.most_after_stop = std::max<std::int64_t>(sum.most_after_stop, counters.most_after_stop);
  sum.longest_stop_us = std::max(sum.longest_stop_us, whole_us(counters.longest_stop));
  sum.longest_hold_ms = std::max(sum.longest_hold_ms, whole_ms(counters.longest_hold));
  sum.starved_ms += whole_ms(counters.starved);
  sum.sending_ms += whole_ms(counters.sending);
  sum.at_ms = db::now_ms();
  store.post("what a port has measured", [sum](db::Database& db) { db::put_port_measures(db, sum); });
}

void Dnc::Impl::write_sometimes(Unit& at) {
  if (db::now_ms() - at.written_ms < 5'000) return;
  at.written_ms = db::now_ms();
  write(at.job->row);
}

void Dnc::Impl::write(const db::PortTransferRow& row) {
  store.post("a transfer over a port", [row](db::Database& db) { db::update_port_transfer(db, row); });
}

void Dnc::Impl::end_job(Unit& at) {
  auto row = at.job->row;
  row.ended_ms = db::now_ms();
  // The hash of what was to be sent is the hash of what was sent only when all of it was.
  if (row.state != "done") row.wire_sha256.clear();
  write(row);
  log::info("port {}: {} {} {}, {} of {} characters{}{}", at.row.name, row.kind, row.name, row.state,
               row.bytes, row.total, row.reason.empty() ? "" : ", ", row.reason);
  at.job.reset();
  at.ended_well = row.state == "done";
  if (!at.ended_well) return end_queue(at, "one_before_failed");
  next_in_queue(at);
}

void Dnc::Impl::next_in_queue(Unit& at) {
  if (at.queue.empty() || busy(at)) return;
  auto next = std::move(at.queue.front());
  at.queue.pop_front();
  start_job(at, std::move(next));
}

void Dnc::Impl::end_queue(Unit& at, const std::string& reason) {
  for (auto& job : std::exchange(at.queue, {})) {
    job.row.state = "cancelled";
    job.row.reason = reason;
    job.row.ended_ms = db::now_ms();
    job.row.wire_sha256.clear();
    write(job.row);
  }
}

void Dnc::Impl::start_job(Unit& at, Job job) {
  job.row.state = "waiting";
  write(job.row);
  auto source = outgoing(job.text, at.settings);
  auto rules = serial::send_rules(at.settings.link, std::chrono::microseconds(at.measured.round_trip_us));
  if (job.armed) rules.start_limit = {};
  if (job.row.kind == "drip") rules.hold_limit = {};
  at.job = std::move(job);
  at.last = {};
  at.line->send(std::move(rules), std::move(source));
}

awaitable<OutgoingFacts> Dnc::Impl::looked_through(OutgoingText text, PortSettings settings) {
  const auto look = [&text, &settings] { return examine(text, settings); };
  co_return co_await workers.run(look);
}

awaitable<db::PortTransferRow> Dnc::Impl::send(Actor actor, std::int64_t port, SendWish wish) {
  access::demand(actor, Action::open_drip);
  if (unit(port).agent != 0) co_return co_await send_to_agent(actor, port, wish);
  Unit& at = unit(port);
  const bool later = busy(at);
  if (later && !wish.queue) throw db::Refusal("port_busy");
  if ((later || wish.armed) && !asks_first(at.settings)) throw db::Refusal("cannot_queue");
  if (later && at.queue.size() >= kLongestQueue) throw db::Refusal("port_busy");
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
  } free{*this, port, !later};
  at.starting = at.starting || !later;
  const auto look = [wish](db::Database& db) {
    const auto program = library::require_program(db, wish.program);
    const auto revision = library::require_revision(db, wish.program, wish.revision);
    if (!revision.released) throw db::Refusal("not_released");
    return std::pair(program, revision);
  };
  const auto [program, revision] = co_await store.run(look);
  Job job;
  job.armed = wish.armed;
  job.text.file = blobs.path(revision.blob.sha256).string();
  if (wish.from_line > 1) {
    const auto machine = unit(port).row.machine;
    if (machine == 0) throw db::Refusal("no_machine");
    const auto restart = co_await checks.restart(wish.program, wish.revision, machine, wish.from_line);
    // Where a line begins does not depend on whether plain blocks could bring the state back; a person who
    // has written a header himself answers for it only when the program could be followed that far.
    if (!restart.reason.empty()) throw db::Refusal(restart.reason, restart.where);
    job.text.offset = restart.offset;
    job.text.header = wish.header.ends_with('\n') ? wish.header : wish.header + "\n";
  }
  const PortSettings settings = unit(port).settings;
  const OutgoingFacts facts = co_await looked_through(job.text, settings);
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
  job.row.settings_json = to_json(settings).dump();
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
  co_await store.run(put);
  Unit& now = unit(port);
  const auto row = job.row;
  if (later && (now.job || now.starting)) {
    now.queue.push_back(std::move(job));
  } else if (later) {
    // What it was to wait for has ended in the meantime, and with it the permission when it ended badly.
    now.queue.push_back(std::move(job));
    if (now.ended_well) {
      next_in_queue(now);
    } else {
      end_queue(now, "one_before_failed");
    }
  } else {
    start_job(now, std::move(job));
  }
  changed(port);
  co_return row;
}

awaitable<db::PortTransferRow> Dnc::send(Actor actor, std::int64_t port, SendWish wish) {
  return impl_->send(std::move(actor), port, std::move(wish));
}

awaitable<RestartAnswer> Dnc::restart(std::int64_t port, std::int64_t program, std::int64_t revision,
                                      StartWish wish) {
  auto& impl = *impl_;
  const auto number = impl.unit(port).row.machine;
  if (number == 0) throw db::Refusal("no_machine");
  const auto look = [=](db::Database& db) {
    const auto row = library::require_revision(db, program, revision);
    const auto machine = db::machine(db, number);
    if (!machine) throw db::Refusal("no_machine");
    return std::pair(row.blob.sha256, machine->profile.ends_with("-m"));
  };
  const auto [sha256, mill] = co_await impl.store.run(look);
  const std::string file = impl.blobs.path(sha256).string();
  const auto find = [&file, &wish, is_mill = mill] { return find_place(file, wish, is_mill); };
  RestartAnswer answer;
  answer.place = co_await impl.workers.run(find);
  if (answer.place.line == 0) throw db::Refusal("place_not_found");
  answer.restart = co_await impl.checks.restart(program, revision, number, answer.place.line);
  co_return answer;
}

awaitable<Tail> Dnc::tail(std::int64_t transfer) {
  auto& impl = *impl_;
  const auto read = [transfer](db::Database& db) { return db::port_transfer(db, transfer); };
  auto row = co_await impl.store.run(read);
  if (!row) throw db::Refusal("not_found", "transfer");
  for (const auto& [id, at] : impl.units)
    if (at->job && at->job->row.id == transfer) row = at->job->row;
  if (row->program == 0 || row->kind == "receive") co_return Tail{};
  OutgoingText text;
  text.file = impl.blobs.path(row->sha256).string();
  text.header = row->header;
  const PortSettings settings = settings_from(nlohmann::json::parse(row->settings_json));
  const auto from_line = row->from_line;
  const auto bytes = static_cast<std::uint64_t>(row->bytes);
  const auto look = [&] { return tail_of(text, settings, from_line, bytes); };
  co_return co_await impl.workers.run(look);
}

}  // namespace headstock::dnc
