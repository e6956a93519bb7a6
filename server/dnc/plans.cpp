// Sending at a time. The clock asks for nothing by itself: a plan is a person's wish, carried out with that
// person's rights of the moment, on a port whose control has to ask before a character goes out.

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "db/user_store.hpp"
#include "protocol/process/log.hpp"
#include "server/access/audit.hpp"
#include "server/dnc/service.hpp"
#include "server/library/programs.hpp"

namespace headstock::dnc {

using access::Action;
using access::Actor;
using boost::asio::awaitable;

namespace {

constexpr auto kLook = std::chrono::seconds(1);
/// Later than this (the server was not running) a plan has been missed: the shop is no longer what it was.
constexpr std::int64_t kLate_ms = 120'000;
constexpr std::int64_t kFarthest_ms = 366ll * 86'400'000;

}  // namespace

awaitable<db::PlanRow> Dnc::plan(Actor actor, std::int64_t port, SendWish wish, std::int64_t at_ms) {
  access::demand(actor, Action::open_drip);
  const Unit& at = impl_->unit(port);
  const auto* protocol = serial::protocol_named(at.settings.link.protocol);
  if (at.agent == 0 && !(protocol != nullptr && protocol->wait_for_start)) throw db::Refusal("cannot_queue");
  if (at.agent != 0 && wish.from_line > 1) throw db::Refusal("not_for_agents");
  if (wish.from_line > 1 && wish.header.find_first_not_of(" \r\n\t") == std::string::npos)
    throw db::Refusal("header_missing");
  const auto now = db::now_ms();
  if (at_ms < now) throw db::Refusal("in_the_past");
  if (at_ms > now + kFarthest_ms) throw db::Refusal("bad_value", "at");
  db::PlanRow row;
  row.port = port;
  row.program = wish.program;
  row.revision = wish.revision;
  row.drip = wish.drip;
  row.from_line = wish.from_line;
  row.header = wish.header;
  row.at_ms = at_ms;
  row.by = actor.user;
  row.by_id = actor.user_id;
  row.created_ms = now;
  const auto put = [&](db::Database& db) {
    db::Transaction transaction(db);
    row.name = library::require_program(db, wish.program).name;
    if (!library::require_revision(db, wish.program, wish.revision).released)
      throw db::Refusal("not_released");
    row.id = db::insert_plan(db, row);
    access::record(db, actor, "port.plan", std::string("port:").append(std::to_string(port)),
                   {{"program", row.name},
                    {"revision", std::to_string(row.revision)},
                    {"at_ms", std::to_string(at_ms)}});
    transaction.commit();
  };
  co_await impl_->store.run(put);
  impl_->changed(port);
  co_return row;
}

awaitable<db::PlanRow> Dnc::cancel_plan(Actor actor, std::int64_t plan) {
  access::demand(actor, Action::cancel_transfer);
  const auto put = [&](db::Database& db) {
    db::Transaction transaction(db);
    auto row = db::plan(db, plan);
    if (!row) throw db::Refusal("not_found", "plan");
    if (row->ended_ms) throw db::Refusal("already_decided");
    row->state = "cancelled";
    row->ended_ms = db::now_ms();
    db::update_plan(db, *row);
    access::record(db, actor, "port.plan.cancel", std::string("port:").append(std::to_string(row->port)),
                   {{"program", row->name}});
    transaction.commit();
    return *row;
  };
  const auto row = co_await impl_->store.run(put);
  impl_->changed(row.port);
  co_return row;
}

void Dnc::Impl::watch_the_clock() {
  clock.expires_after(kLook);
  clock.async_wait([weak = weak_from_this()](const boost::system::error_code& error) {
    const auto self = weak.lock();
    if (error || !self || self->stopped) return;
    boost::asio::co_spawn(
        self->io, [self]() -> awaitable<void> { co_await self->look_at_plans(); },
        [self](std::exception_ptr failed) {
          if (failed) log::error("the plans of the ports could not be looked at");
          if (!self->stopped) self->watch_the_clock();
        });
  });
}

awaitable<void> Dnc::Impl::look_at_plans() {
  const auto read = [](db::Database& db) { return db::due_plans(db, db::now_ms()); };
  for (auto& row : co_await store.run(read)) co_await carry_out(std::move(row));
}

awaitable<void> Dnc::Impl::carry_out(db::PlanRow row) {
  // First the row: a plan that has been taken up is not taken up again, whatever happens now.
  const auto taken = db::now_ms();
  const bool late = taken - row.at_ms > kLate_ms;
  row.state = late ? "missed" : "started";
  row.reason = late ? "plan_missed" : "";
  row.ended_ms = taken;
  const auto take = [&row](db::Database& db) -> std::optional<Actor> {
    const auto now = db::plan(db, row.id);
    if (!now || now->ended_ms) return std::nullopt;
    db::update_plan(db, row);
    const auto user = db::user(db, row.by_id);
    if (!user || user->disabled) return Actor{row.by_id, row.by, access::Role::viewer, "plan"};
    return Actor{row.by_id, row.by, access::role_from(user->role).value_or(access::Role::viewer), "plan"};
  };
  const auto actor = co_await store.run(take);
  if (!actor || late) co_return;
  SendWish wish;
  wish.program = row.program;
  wish.revision = row.revision;
  wish.drip = row.drip;
  wish.from_line = row.from_line;
  wish.header = row.header;
  const auto found = units.find(row.port);
  const bool line = found != units.end() && found->second->agent == 0;
  wish.queue = wish.armed = line;
  try {
    row.transfer = (co_await send(*actor, row.port, wish)).id;
  } catch (const db::Refusal& refusal) {
    row.state = "refused";
    row.reason = refusal.code();
  }
  log::info("plan {} of {}: {} {} {}", row.id, row.by, row.name, row.state, row.reason);
  const auto put = [&row](db::Database& db) { db::update_plan(db, row); };
  co_await store.run(put);
  changed(row.port);
}

}  // namespace headstock::dnc
