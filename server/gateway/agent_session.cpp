#include "server/gateway/agent_session.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>

#include "protocol/process/log.hpp"
#include "protocol/wire/certificates.hpp"
#include "protocol/wire/expect.hpp"
#include "protocol/wire/tls.hpp"

namespace headstock::server {
namespace {

namespace asio = boost::asio;
using nlohmann::json;
using std::chrono::milliseconds;
using wire::Type;

constexpr std::ptrdiff_t kMaxEventBatches = 4;
constexpr std::size_t kMaxEvents = 256;
constexpr int kMaxRequests = 4;  // of one machine at a time
/// An agent that sends live states faster than agreed is thinned out, not trusted.
constexpr milliseconds kLeastLiveInterval{50};
/// How long an older connection may take to prove that it still lives.
constexpr milliseconds kProofLimit{1'500};

std::int64_t now_ms() {
  return std::chrono::duration_cast<milliseconds>(std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

AgentSession::AgentSession(std::shared_ptr<SessionOwner> owner, std::shared_ptr<wire::Connection> connection)
    : owner_(std::move(owner)),
      connection_(std::move(connection)),
      to_store_(connection_->executor()),
      tick_(connection_->executor()) {}

void AgentSession::refuse(const std::string& reason, const std::string& text) {
  connection_->send(Type::refuse, 0, wire::encode(wire::Refuse{reason, text, {wire::kVersion}}));
  connection_->finish(reason + (text.empty() ? "" : ": " + text));
}

asio::awaitable<void> AgentSession::run() {
  const auto self = shared_from_this();
  const std::string peer = connection_->peer();
  // From here to hello or enrol one limit holds: whoever only connects does not stay.
  auto watching = [self] { return self->watch(); };
  asio::co_spawn(connection_->executor(), watching, asio::detached);
  try {
    if (co_await connection_->handshake(asio::ssl::stream_base::server, owner_->options().handshake_limit) &&
        !owner_->stopped()) {
      if (wire::peer_certificate(connection_->tls()).empty()) {
        co_await enrol();
      } else if (co_await identify() && co_await greet()) {
        wire::Frame frame;
        while (co_await connection_->receive(frame)) {
          if (owner_->stopped()) break;
          handle(frame);
        }
      }
    }
  } catch (const std::exception& error) {
    connection_->close(std::string("error: ") + error.what());
  }
  // A refusal on its way out needs its connection read to the end.
  wire::Frame rest;
  while (co_await connection_->receive(rest)) connection_->close("ended");
  const std::string reason = connection_->reason();
  give_up_answers();
  to_store_.notify();
  tick_.notify();
  if (greeted_) {
    greeted_ = false;
    log::warning("gateway: machine {} at {} disconnected: {}", machine_, peer, reason);
    owner_->gone(self);
  } else {
    log::warning("gateway: connection from {} ended: {}", peer, reason);
  }
}

// ---- who is it

asio::awaitable<void> AgentSession::enrol() {
  wire::Frame frame;
  if (!co_await connection_->receive(frame)) co_return;
  wire::Enrol request;
  if (frame.type != Type::enrol)
    co_return refuse("certificate_required", "only enrolment without a certificate");
  if (const std::string wrong = wire::decode(frame.body, request); !wrong.empty())
    co_return connection_->close("enrol: " + wrong);
  const std::int64_t machine = co_await owner_->host().redeem_token(request.token);
  if (owner_->stopped()) co_return;
  if (machine <= 0) co_return refuse("bad_token", "the token is unknown, used or expired; make a new one");
  wire::IssuedCertificate issued;
  try {
    issued = owner_->sign(request.request_pem, machine);
  } catch (const wire::CertificateError& bad) {
    co_return refuse("bad_request", bad.what());
  }
  co_await owner_->host().certificate_issued(machine, issued.serial_hex);
  const std::string name = co_await owner_->host().machine_name(machine);
  if (owner_->stopped()) co_return;
  // The old certificate is revoked: whoever is connected with it goes.
  if (const auto older = owner_->session_of(machine))
    older->refuse("revoked", "the machine was enrolled again");
  connection_->send(Type::enrolled, 0,
                    wire::encode(wire::Enrolled{issued.pem, owner_->ca_pem(), machine, name}));
  log::info("gateway: machine {} \"{}\" enrolled from {}", machine, name, connection_->peer());
  connection_->finish("enrolled");
}

asio::awaitable<bool> AgentSession::identify() {
  const auto info = wire::read_certificate(wire::peer_certificate(connection_->tls()));
  const std::int64_t machine = wire::machine_of_name(info.common_name);
  if (machine == 0) {
    refuse("not_an_agent", "a certificate of " + info.common_name);
    co_return false;
  }
  serial_ = info.serial_hex;
  machine_ = machine;
  const bool valid = co_await owner_->host().certificate_valid(machine, serial_);
  if (owner_->stopped()) co_return false;
  if (!valid) refuse("revoked", "this certificate was replaced or the machine removed");
  co_return valid;
}

asio::awaitable<bool> AgentSession::takes_the_place() {
  const auto older = owner_->session_of(machine_);
  if (!older) co_return true;
  // A machine that lost its link comes back before the old connection is noticed as dead: ask it.
  const auto asked = wire::Connection::Clock::now();
  older->connection()->send(Type::ping, 0, wire::encode(wire::Ping{++older->pings_, now_ms()}));
  while (older->open() && connection_->open() && older->connection()->last_heard() < asked &&
         wire::Connection::Clock::now() - asked < kProofLimit)
    co_await tick_.wait_for(milliseconds(20));
  if (owner_->stopped()) co_return false;
  if (older->open() && older->connection()->last_heard() >= asked) {
    log::error("gateway: machine {}: {} uses the identity of {}, which still answers", machine_,
                  connection_->peer(), older->connection()->peer());
    refuse("identity_in_use", "another agent with this certificate is connected");
    co_return false;
  }
  older->connection()->close("replaced by a newer connection");
  owner_->gone(older);
  co_return true;
}

asio::awaitable<bool> AgentSession::greet() {
  wire::Frame frame;
  if (!co_await connection_->receive(frame)) co_return false;
  wire::Hello hello;
  if (frame.type != Type::hello) {
    connection_->close("the first message is no hello");
    co_return false;
  }
  if (const std::string wrong = wire::decode(frame.body, hello); !wrong.empty()) {
    connection_->close("hello: " + wrong);
    co_return false;
  }
  if (std::ranges::find(hello.versions, std::uint64_t{wire::kVersion}) == hello.versions.end()) {
    refuse("version", "no version of the link that both sides speak");
    co_return false;
  }
  if (!co_await takes_the_place()) co_return false;
  spool_id_ = hello.spool_id;
  greeted_ = true;
  connection_->send(Type::welcome, 0, wire::encode(wire::Welcome{wire::kVersion, now_ms(), machine_, 0}));
  log::info("gateway: machine {} \"{}\" connected from {}", machine_, hello.name, connection_->peer());
  asio::co_spawn(
      connection_->executor(), [self = shared_from_this()] { return self->store_loop(); }, asio::detached);
  owner_->greeted(shared_from_this(), hello);
  co_return true;
}

asio::awaitable<void> AgentSession::watch() {
  const auto self = shared_from_this();
  const GatewayOptions& options = owner_->options();
  const auto started = wire::Connection::Clock::now();
  while (connection_->open() && !owner_->stopped()) {
    co_await tick_.wait_for(options.ping_interval);
    if (!connection_->open()) break;
    if (!greeted_) {
      if (wire::Connection::Clock::now() - started > options.handshake_limit)
        connection_->close("no hello within the time");
      continue;
    }
    connection_->send(Type::ping, 0, wire::encode(wire::Ping{++pings_, now_ms()}));
    if (connection_->silence() > options.silence_limit) connection_->close("nothing heard from the agent");
  }
}

// ---- what it says

bool AgentSession::json_body(const wire::Frame& frame, json& body) {
  std::string wrong = wire::decode_json(frame.body, body);
  if (wrong.empty() && !body.is_object()) wrong = "not a map";
  if (!wrong.empty())
    connection_->close("message " + std::to_string(static_cast<int>(frame.type)) + ": " + wrong);
  return wrong.empty();
}

void AgentSession::handle(const wire::Frame& frame) {
  switch (frame.type) {
    case Type::ping:
      connection_->send(Type::pong, 0, frame.body);
      break;
    case Type::live: {
      const auto now = wire::Connection::Clock::now();
      json live;
      if (now - last_live_ < kLeastLiveInterval || !json_body(frame, live)) break;
      last_live_ = now;
      owner_->host().live(machine_, std::move(live));
      break;
    }
    case Type::events:
      on_events(frame);
      break;
    case Type::census: {
      json census;
      if (!json_body(frame, census)) break;
      json programs = census.value("programs", json::array());
      if (!programs.is_array()) return connection_->close("census: programs: not a list");
      newest_to_store(Type::census, std::move(programs));
      break;
    }
    case Type::data_report: {
      json report;
      if (!json_body(frame, report)) break;
      newest_to_store(Type::data_report, std::move(report));
      break;
    }
    case Type::data_result:
      on_data_result(frame);
      break;
    case Type::command_result:
      wire::expect<wire::CommandResult>(*connection_, frame, [&](const auto& m) {
        const auto found = answers_.find(m.id);
        if (found == answers_.end()) return;  // too late
        found->second->answer = {m.accepted, m.reason};
        found->second->done = true;
        found->second->arrived.notify();
      });
      break;
    case Type::credit:
    case Type::drip_resume:
      wire::expect<wire::Credit>(*connection_, frame,
                                 [&](const auto& m) { owner_->on_credit(*this, frame, m); });
      break;
    case Type::transfer_result:
      wire::expect<wire::TransferResult>(*connection_, frame, [&](const auto& m) { on_result(m); });
      break;
    case Type::data:
    case Type::data_end:
      on_data(frame);
      break;
    case Type::program_request:
      wire::expect<wire::ProgramGet>(*connection_, frame, [&](const auto& m) {
        if (requests_under_way_ >= kMaxRequests)
          return void(connection_->send(Type::request_answer, 0,
                                        wire::encode(wire::CommandResult{m.transfer, false, "busy"})));
        asio::co_spawn(
            connection_->executor(),
            [self = shared_from_this(), m] { return self->program_requested(m.transfer, m.name); },
            asio::detached);
      });
      break;
    case Type::refuse:
      // Good-bye: an agent that is switched off says "shutdown", one that is cut says nothing.
      wire::expect<wire::Refuse>(*connection_, frame, [&](const auto& m) { connection_->close(m.reason); });
      break;
    case Type::renew:
      wire::expect<wire::Enrol>(*connection_, frame, [&](const auto& m) { renew(m); });
      break;
    case Type::certificate_stored:
      wire::expect<wire::CertificateStored>(*connection_, frame, [&](const auto& m) {
        if (renewed_serial_.empty() || m.serial != renewed_serial_) return;
        asio::co_spawn(
            connection_->executor(),
            [self = shared_from_this(), serial = m.serial] { return self->certificate_stored(serial); },
            asio::detached);
      });
      break;
    default:
      break;  // a type of a newer agent
  }
}

void AgentSession::on_events(const wire::Frame& frame) {
  json body;
  if (!json_body(frame, body)) return;
  json events = body.value("events", json());
  if (!events.is_array() || events.empty() || events.size() > kMaxEvents)
    return connection_->close("events: not a list of 1…256");
  std::uint64_t last = 0;
  for (const json& event : events) {
    const bool sound = event.is_object() && event.contains("seq") && event["seq"].is_number_unsigned() &&
                       event.contains("at_ms") && event["at_ms"].is_number_integer() &&
                       event.contains("kind") && event["kind"].is_string() &&
                       event["seq"].get<std::uint64_t>() > last;
    if (!sound) return connection_->close("events: seq, at_ms or kind missing or out of order");
    last = event["seq"].get<std::uint64_t>();
  }
  const auto waiting = std::ranges::count(told_, Type::events, &Told::type);
  if (waiting >= kMaxEventBatches) return connection_->close("more events than were acknowledged");
  told_.push_back({Type::events, std::move(events)});
  to_store_.notify();
}

/// Only the newest of its type waits, at the place in the order that it was said at.
void AgentSession::newest_to_store(Type type, json body) {
  std::erase_if(told_, [type](const Told& told) { return told.type == type; });
  told_.push_back({type, std::move(body)});
  to_store_.notify();
}

asio::awaitable<void> AgentSession::store(Told& told) {
  GatewayHost& host = owner_->host();
  if (told.type == Type::events) {
    const std::uint64_t committed = co_await host.events(machine_, spool_id_, std::move(told.body));
    connection_->send(Type::events_ack, 0, wire::encode(wire::EventsAck{committed}));
  } else if (told.type == Type::census) {
    co_await host.census(machine_, std::move(told.body));
  } else {
    co_await host.data_report(machine_, spool_id_, told.body);
  }
}

/// Hands what was said to the store, one after the other in that order: a report of values is held against
/// the events before it and none behind it. The connection goes on being read meanwhile.
asio::awaitable<void> AgentSession::store_loop() {
  const auto self = shared_from_this();
  while (open() && !owner_->stopped()) {
    try {
      if (told_.empty()) {
        co_await to_store_.wait();
      } else {
        Told next = std::move(told_.front());
        told_.pop_front();
        co_await store(next);
      }
    } catch (const std::exception& error) {
      connection_->close(std::string("the store refused what the machine reported: ") + error.what());
    }
  }
}

// ---- answers

void AgentSession::renew(const wire::Enrol& request) {
  try {
    const auto issued = owner_->sign(request.request_pem, machine_);
    renewed_serial_ = issued.serial_hex;
    connection_->send(Type::enrolled, 0,
                      wire::encode(wire::Enrolled{issued.pem, owner_->ca_pem(), machine_, ""}));
  } catch (const wire::CertificateError& bad) {
    log::error("gateway: machine {}: certificate not renewed: {}", machine_, bad.what());
  }
}

asio::awaitable<void> AgentSession::certificate_stored(std::string serial) {
  const auto self = shared_from_this();
  try {
    co_await owner_->host().certificate_issued(machine_, serial);
    if (owner_->stopped()) co_return;
    serial_ = serial;
    connection_->send(Type::certificate_current, 0, wire::encode(wire::CertificateStored{serial}));
    log::info("gateway: machine {}: certificate renewed", machine_);
  } catch (const std::exception& error) {
    log::error("gateway: machine {}: certificate not renewed: {}", machine_, error.what());
  }
}

}  // namespace headstock::server
