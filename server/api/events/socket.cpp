#include "server/api/events/socket.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "db/time.hpp"
#include "protocol/process/log.hpp"
#include "server/api/events/hub.hpp"
#include "server/fleet/fleet.hpp"

namespace headstock::api {

namespace {

namespace asio = boost::asio;
using asio::awaitable;
using Clock = Outbox::Clock;
using std::chrono::seconds;

constexpr seconds stuck_after{30};
constexpr seconds look_again_after{15};

struct Session {
  Session(Services& given, std::shared_ptr<SocketClient> socket)
      : services(given), client(std::move(socket)), wake(services.io), clock(services.io) {
    wake.expires_at(asio::steady_timer::time_point::max());
  }
  Services& services;
  std::shared_ptr<SocketClient> client;
  std::unique_ptr<fleet::Changes::Subscription> subscription;
  Wishes wishes;
  Outbox outbox;
  asio::steady_timer wake;    ///< cancelled when there may be something to send
  asio::steady_timer clock;   ///< the second's tick and the watch over the writer
  std::optional<Clock::time_point> writing_since;
  bool over = false;

  void end() {
    over = true;
    client->cut();
    wake.cancel();
    clock.cancel();
  }
};

Message message_of(const nlohmann::json& value) {
  return std::make_shared<const std::string>(value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

Message snapshot_of(Session& session) {
  nlohmann::json machines = nlohmann::json::array();
  for (auto& live : session.services.fleet.all_live()) {
    const auto id = live.value("machine", std::int64_t{0});
    if (session.wishes.floor() || session.wishes.machine(id)) machines.push_back(std::move(live));
  }
  return message_of({{"type", "snapshot"}, {"machines", std::move(machines)}, {"now", db::iso_time(db::now_ms())}});
}

/// Moves what the shop published into the outbox. A client that was too slow for the events gets the states anew.
void collect(Session& session) {
  for (const auto& change : session.subscription->take()) {
    bool fits = session.outbox.put(change, session.wishes);
    if (fits && change.topic == "resync") fits = session.outbox.put(snapshot_of(session), Outbox::Kind::needed);
    if (!fits) {
      log::info("a browser was too slow for its events and was closed");
      session.end();
      return;
    }
  }
}

/// One message at a time, so that nothing piles up behind a slow client but the newest states.
awaitable<void> write(std::shared_ptr<Session> session) {
  while (!session->over) {
    collect(*session);
    const auto now = Clock::now();
    if (const auto message = session->outbox.take(now)) {
      session->writing_since = now;
      const bool sent = co_await session->client->send(message);
      session->writing_since.reset();
      if (!sent) break;
      continue;
    }
    if (session->over) break;
    session->wake.expires_at(session->outbox.due().value_or(asio::steady_timer::time_point::max()));
    co_await session->wake.async_wait(asio::as_tuple(asio::use_awaitable));
  }
  session->end();
}

awaitable<void> tick(std::shared_ptr<Session> session,
                     std::function<awaitable<Principal>(std::string)> authenticate, Principal who) {
  auto looked = Clock::now();
  while (!session->over) {
    session->clock.expires_after(seconds(1));
    co_await session->clock.async_wait(asio::as_tuple(asio::use_awaitable));
    if (session->over) break;
    const auto now = Clock::now();
    if (session->writing_since && now - *session->writing_since > stuck_after) {
      log::info("a browser stopped reading and was closed");
      break;
    }
    if (now - looked > look_again_after) {
      looked = now;
      Principal still;
      try {
        still = co_await authenticate(who.token);
      } catch (const std::exception& error) {
        log::warning("a session could not be looked up: {}", error.what());
        continue;
      }
      if (still.role == Role::none) break;
    }
    if (!session->wishes.any()) continue;
    session->outbox.put(message_of({{"type", "tick"}, {"now", db::iso_time(db::now_ms())}}), Outbox::Kind::droppable);
    session->wake.cancel();
  }
  session->end();
}

}  // namespace

awaitable<void> serve_events(Services& services, std::function<awaitable<Principal>(std::string)> authenticate,
                             std::shared_ptr<SocketClient> client, Principal who) {
  const auto session = std::make_shared<Session>(services, client);
  // Published from inside other work: the writer runs later, from the loop.
  session->subscription = services.changes.subscribe([raw = session.get()] { raw->wake.cancel(); });
  asio::co_spawn(services.io, write(session), asio::detached);
  asio::co_spawn(services.io, tick(session, authenticate, who), asio::detached);
  while (!session->over) {
    const auto message = co_await client->receive();
    if (!message) break;
    if (!session->wishes.read(*message)) {
      session->outbox.put(message_of({{"type", "error"}, {"code", "bad_request"}}), Outbox::Kind::droppable);
    } else {
      session->subscription->take();   // what came before is in the snapshot
      session->outbox.put(snapshot_of(*session), Outbox::Kind::needed);
    }
    session->wake.cancel();
  }
  session->end();
}

}  // namespace headstock::api
