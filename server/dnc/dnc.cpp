#include "server/dnc/dnc.hpp"

#include <algorithm>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "protocol/process/log.hpp"
#include "server/dnc/agent_port.hpp"
#include "server/dnc/ports.hpp"
#include "server/dnc/service.hpp"

namespace headstock::dnc {

namespace asio = boost::asio;
using access::Action;
using access::Actor;
using asio::awaitable;

Dnc::Impl::Impl(asio::io_context& the_io, db::Store& the_store, db::Pool& the_workers,
                const db::Blobs& the_blobs, library::Checks& the_checks,
                std::function<void(std::int64_t)> on_change)
    : io(the_io),
      store(the_store),
      workers(the_workers),
      blobs(the_blobs),
      checks(the_checks),
      changed(std::move(on_change)),
      clock(the_io) {}

Unit& Dnc::Impl::unit(std::int64_t port) {
  const auto found = units.find(port);
  if (found == units.end()) throw db::Refusal("not_found", "port");
  return *found->second;
}

void Dnc::Impl::install(const db::PortRow& row, const std::optional<db::PortMeasuresRow>& measured) {
  auto& place = units[row.id];
  auto kept = place ? std::move(place->queue) : std::deque<Job>();
  const auto known = measured ? *measured : place ? place->measured : db::PortMeasuresRow{};
  place = std::make_unique<Unit>();
  place->row = row;
  place->queue = std::move(kept);
  place->measured = known;
  place->settings = settings_from(nlohmann::json::parse(row.settings_json));
  place->rules = rules_from(nlohmann::json::parse(row.rules_json));
  place->agent = agent_of(row.address);
  if (place->agent != 0) return;
  const auto address = serial::address_of(row.address);
  if (!address) return;
  const auto id = row.id;
  PortEvents events;
  events.state = [this, id](PortState now) { on_state(id, std::move(now)); };
  events.sending = [this, id](const serial::SendReport& report) { on_sending(id, report); };
  events.receiving = [this, id](const serial::ReceiveReport& report,
                                const std::shared_ptr<std::string>& text) { on_receiving(id, report, text); };
  events.looped = [this, id](const serial::LoopReport& report) { on_looped(id, report); };
  place->line = std::make_unique<PortLine>(lines, io.get_executor(), *address, place->settings, row.listens,
                                           std::move(events));
}

void Dnc::Impl::on_state(std::int64_t port, PortState now) {
  Unit& at = unit(port);
  if (now.state == "failed" && at.now.state != "failed")
    log::warning("port {} ({}): {} {}", at.row.name, at.row.address, now.reason, now.text);
  // A line that was lost ends the permission of what waits, even when nothing was under way.
  if (now.state == "failed" && !at.job) end_queue(at, "line_lost");
  at.now = std::move(now);
  changed(port);
}

void Dnc::Impl::on_looped(std::int64_t port, const serial::LoopReport& report) {
  Unit& at = unit(port);
  at.loop = report;
  if (report.ok) {
    at.measured.port = port;
    at.measured.round_trip_us = report.round_trip_us;
    at.measured.at_ms = db::now_ms();
    store.post("what a port has measured",
               [row = at.measured](db::Database& db) { db::put_port_measures(db, row); });
  }
  if (at.looping) at.looping->cancel();
}

Dnc::Dnc(asio::io_context& io, db::Store& store, db::Pool& workers, const db::Blobs& blobs,
         library::Checks& checks, std::function<void(std::int64_t)> changed)
    : impl_(std::make_shared<Impl>(io, store, workers, blobs, checks, std::move(changed))) {}

Dnc::~Dnc() {
  impl_->units.clear();
}

awaitable<void> Dnc::start() {
  const auto read = [](db::Database& db) {
    db::end_open_port_transfers(db, "server_restarted", db::now_ms());
    std::vector<std::pair<db::PortRow, std::optional<db::PortMeasuresRow>>> found;
    for (auto& row : db::ports(db)) {
      auto measured = db::port_measures(db, row.id);
      found.emplace_back(std::move(row), std::move(measured));
    }
    return found;
  };
  for (const auto& [row, measured] : co_await impl_->store.run(read)) impl_->install(row, measured);
}

void Dnc::watch_the_clock() {
  impl_->watch_the_clock();
}

void Dnc::stop() {
  impl_->stopped = true;
  impl_->clock.cancel();
  for (auto& [id, unit] : impl_->units) {
    impl_->end_queue(*unit, "server_stopped");
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

PortView view_of(const Unit& unit, const AgentCarrier& agents) {
  PortView view;
  view.row = unit.row;
  view.now = unit.now;
  view.measured = unit.measured;
  view.is_agent = unit.agent != 0;
  if (view.is_agent) {
    show_agent(unit, agents, view);
    return view;
  }
  if (unit.job) view.transfer = unit.job->row;
  for (const auto& job : unit.queue) view.queue.push_back(job.row);
  const auto round_trip = std::chrono::microseconds(unit.measured.round_trip_us);
  view.window = serial::window_of(unit.settings.link, round_trip);
  view.stop_margin = serial::stop_margin(unit.settings.link, round_trip);
  return view;
}

}  // namespace

std::vector<PortView> Dnc::views() const {
  std::vector<PortView> views;
  for (const auto& [id, unit] : impl_->units) views.push_back(view_of(*unit, impl_->agents));
  return views;
}

PortView Dnc::view(std::int64_t port) const {
  return view_of(impl_->unit(port), impl_->agents);
}

awaitable<db::PortRow> Dnc::create(Actor actor, nlohmann::json fields) {
  const auto make = [&](db::Database& db) { return create_port(db, actor, fields, db::now_ms()); };
  const auto row = co_await impl_->store.run(make);
  impl_->install(row, std::nullopt);
  impl_->changed(row.id);
  co_return row;
}

awaitable<db::PortRow> Dnc::change(Actor actor, std::int64_t port, nlohmann::json fields) {
  if (Impl::busy(impl_->unit(port))) throw db::Refusal("port_busy");
  const auto make = [&](db::Database& db) { return change_port(db, actor, port, fields, db::now_ms()); };
  const auto row = co_await impl_->store.run(make);
  // Another line or another speed: what was measured is no longer true.
  const auto& before = impl_->unit(port).row;
  const bool same = before.address == row.address && before.settings_json == row.settings_json;
  impl_->install(row, same ? std::nullopt : std::optional<db::PortMeasuresRow>(db::PortMeasuresRow{}));
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

awaitable<db::PortTransferRow> Dnc::receive(Actor actor, std::int64_t port) {
  access::demand(actor, Action::open_drip);
  Unit& at = impl_->unit(port);
  if (at.agent != 0) throw db::Refusal("not_for_agents");
  if (Impl::busy(at)) throw db::Refusal("port_busy");
  impl_->begin_receiving(at, actor.user);
  at.line->receive();
  impl_->changed(port);
  co_return at.job->row;
}

void Dnc::pause(const Actor& actor, std::int64_t port) {
  access::demand(actor, Action::cancel_transfer);
  Unit& at = impl_->unit(port);
  if (at.agent != 0) throw db::Refusal("not_for_agents");
  if (!at.job || at.job->row.kind == "receive") throw db::Refusal("nothing_under_way");
  at.line->pause();
}

void Dnc::resume(const Actor& actor, std::int64_t port) {
  access::demand(actor, Action::open_drip);
  Unit& at = impl_->unit(port);
  if (at.agent != 0) throw db::Refusal("not_for_agents");
  if (!at.job || at.job->row.kind == "receive") throw db::Refusal("nothing_under_way");
  at.line->resume();
}

void Dnc::cancel(const Actor& actor, std::int64_t port) {
  access::demand(actor, Action::cancel_transfer);
  Unit& at = impl_->unit(port);
  if (at.agent != 0) return impl_->cancel_agent(actor, at);
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
  if (at.agent != 0) throw db::Refusal("not_for_agents");
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
