#include "link/session.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>

#include "link/live_json.hpp"
#include "protocol/process/log.hpp"
#include "protocol/wire/digest.hpp"
#include "protocol/wire/expect.hpp"

namespace headstock::link {
namespace {

namespace asio = boost::asio;
using nlohmann::json;
using wire::Type;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxTrail = 100;
/// Streams of resumed drip-feeds are numbered by the agent; the server's own numbers of a connection start
/// at 1.
constexpr std::uint32_t kResumedStreams = 0x8000'0000u;
/// Newest wins: nothing live is queued behind more than this.
constexpr std::size_t kLiveWaiting = 64u << 10;

std::int64_t now_ms() {
  return std::chrono::duration_cast<std::chrono::milliseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace

Session::Session(std::shared_ptr<LinkParts> parts, std::shared_ptr<wire::Connection> connection)
    : parts_(std::move(parts)), connection_(std::move(connection)), tick_(connection_->executor()) {}

asio::awaitable<bool> Session::welcomed() {
  const LinkOptions& options = parts_->options;
  wire::Hello hello;
  hello.versions = {wire::kVersion};
  hello.software = options.software;
  hello.name = options.machine_name;
  hello.profile = options.profile;
  hello.axes = options.axes;
  hello.boot_id = parts_->boot_id;
  hello.spool_id = parts_->spool.id();
  hello.acknowledged = parts_->spool.acknowledged();
  hello.memory_bytes = parts_->memory.limit_bytes();
  hello.census_hash = parts_->memory.census_hash();
  hello.machine_toml = options.machine_toml;
  for (const auto& [id, drip] : parts_->transfers.drips) hello.transfers.push_back(id);
  for (const auto& [id, result] : parts_->transfers.unconfirmed) {
    if (hello.transfers.size() >= 64) break;  // the list's bound on the wire
    hello.transfers.push_back(id);
  }
  connection_->send(Type::hello, 0, wire::encode(hello));

  wire::Frame frame;
  while (co_await connection_->receive(frame)) {
    if (frame.type == Type::welcome) {
      wire::Welcome welcome;
      if (const std::string wrong = wire::decode(frame.body, welcome); !wrong.empty()) {
        connection_->close("welcome: " + wrong);
        co_return false;
      }
      machine_ = welcome.machine;
      welcomed_ = true;
      if (on_welcome_) on_welcome_();
      if (!parts_->stopped)
        parts_->host.link_up({welcome.machine, welcome.server_time_ms, welcome.parts_required});
      co_return true;
    }
    if (frame.type == Type::refuse) {
      wire::Refuse refuse;
      if (wire::decode(frame.body, refuse).empty()) {
        refusal_ = refuse.reason;
        connection_->close("refused by the server: " + refuse.reason +
                           (refuse.text.empty() ? "" : " (" + refuse.text + ")"));
      }
    }
  }
  co_return false;
}

asio::awaitable<bool> Session::run() {
  const auto self = shared_from_this();
  if (!co_await welcomed()) co_return false;
  acknowledged_ = sent_event_ = parts_->spool.acknowledged();
  if (parts_->identity.trying_renewed()) parts_->identity.keep_renewed();
  parts_->requests.link_is_up();
  send_census();
  report_data();
  for (const auto& [id, unconfirmed] : parts_->transfers.unconfirmed)
    connection_->send(Type::transfer_result, 0, wire::encode(unconfirmed));
  std::uint32_t resumed = kResumedStreams;
  for (auto& [id, drip] : parts_->transfers.drips) {
    drip.stream = ++resumed;
    if (const auto grant = drip.feed->resume()) send_credit(Type::drip_resume, drip, *grant);
  }
  drips_changed();
  pump_events();
  maybe_renew();
  asio::co_spawn(
      connection_->executor(), [self] { return self->report_loop(); }, asio::detached);

  wire::Frame frame;
  while (co_await connection_->receive(frame)) {
    if (parts_->stopped) break;
    handle(frame);
  }
  welcomed_ = false;
  parts_->requests.link_is_lost();
  puts_.clear();  // the bytes stay on disk for the next attempt
  tick_.notify();
  co_return true;
}

asio::awaitable<void> Session::report_loop() {
  const auto self = shared_from_this();
  const LinkOptions& options = parts_->options;
  auto next_live = Clock::now(), next_ping = next_live;
  while (active()) {
    const auto now = Clock::now();
    sample_trail();
    report_data();
    if (now >= next_live) {
      send_live();
      next_live = now + std::max(options.live_interval, std::chrono::milliseconds(100));
    }
    if (now >= next_ping) {
      connection_->send(Type::ping, 0, wire::encode(wire::Ping{++pings_, now_ms()}));
      next_ping = now + options.ping_interval;
    }
    if (connection_->silence() > options.silence_limit) connection_->close("nothing heard from the server");
    co_await tick_.wait_for(std::max(options.trail_interval, std::chrono::milliseconds(10)));
  }
}

void Session::handle(const wire::Frame& frame) {
  const std::uint32_t stream = frame.stream;
  switch (frame.type) {
    case Type::ping:
      connection_->send(Type::pong, 0, frame.body);
      break;
    case Type::events_ack:
      wire::expect<wire::EventsAck>(*connection_, frame, [&](const auto& m) {
        if (m.sequence > sent_event_) return connection_->close("events acknowledged that were never sent");
        parts_->spool.acknowledge(m.sequence);
        acknowledged_ = std::max(acknowledged_, m.sequence);
        if (acknowledged_ < sent_event_)
          sent_event_ = acknowledged_;  // only a part was taken: the rest again
        pump_events();
        report_data();
      });
      break;
    case Type::command:
      wire::expect<wire::Command>(*connection_, frame, [&](const auto& m) { on_command(m); });
      break;
    case Type::data_write:
      on_data_write(frame);
      break;
    case Type::program_put:
      wire::expect<wire::TransferOpen>(*connection_, frame, [&](const auto& m) { on_put(stream, m); });
      break;
    case Type::program_get:
      wire::expect<wire::ProgramGet>(*connection_, frame, [&](const auto& m) {
        asio::co_spawn(
            connection_->executor(),
            [self = shared_from_this(), stream, m] { return self->send_program(stream, m); }, asio::detached);
      });
      break;
    case Type::program_delete:
      wire::expect<wire::Command>(*connection_, frame, [&](const auto& m) {
        const MemoryResult removed = parts_->memory.remove(m.name);
        answer(m.id, removed.ok(), removed.reason);
      });
      break;
    case Type::drip_open:
      wire::expect<wire::TransferOpen>(*connection_, frame, [&](const auto& m) { on_drip_open(stream, m); });
      break;
    case Type::data:
      on_data(frame);
      break;
    case Type::data_end:
      wire::expect<wire::DataEnd>(*connection_, frame, [&](const auto& m) { on_data_end(stream, m); });
      break;
    case Type::transfer_cancel:
      wire::expect<wire::TransferCancel>(*connection_, frame, [&](const auto& m) { on_cancel(m); });
      break;
    case Type::transfer_closed:
      wire::expect<wire::TransferCancel>(*connection_, frame,
                                 [&](const auto& m) { parts_->transfers.unconfirmed.erase(m.transfer); });
      break;
    case Type::request_answer:
      wire::expect<wire::CommandResult>(*connection_, frame, [&](const auto& m) {
        if (const auto name = parts_->requests.answered(m.id, m.accepted, m.reason))
          parts_->host.request_answered(*name, {m.accepted, m.reason});
      });
      break;
    case Type::enrolled:
      wire::expect<wire::Enrolled>(*connection_, frame, [&](const auto& m) { on_renewed(m); });
      break;
    case Type::certificate_current:
      parts_->identity.keep_renewed();
      break;
    case Type::refuse:
      wire::expect<wire::Refuse>(*connection_, frame, [&](const auto& m) {
        refusal_ = m.reason;
        connection_->close("closed by the server: " + m.reason);
      });
      break;
    default:
      break;  // a type of a newer server
  }
}

// ---- events, census, live

void Session::events_committed() {
  parts_->host.events_committed();
  pump_events();
}

void Session::pump_events() {
  if (!active() || sent_event_ > acknowledged_) return;
  const auto events = parts_->spool.read_after(acknowledged_);
  if (events.empty()) return;
  json list = json::array();
  for (const SpooledEvent& event : events) {
    json item = json::parse(event.body, nullptr, false);
    if (!item.is_object()) item = json::object();  // the sequence has to go on whatever stands in the body
    item["seq"] = event.sequence;
    item["at_ms"] = event.at_ms;
    item["kind"] = event.kind;
    list.push_back(std::move(item));
  }
  sent_event_ = events.back().sequence;
  connection_->send(Type::events, 0, wire::encode_json({{"events", std::move(list)}}));
}

void Session::memory_changed() {
  send_census();
}

void Session::send_census() {
  if (!active()) return;
  json list = json::array();
  for (const ResidentProgram& p : parts_->memory.census())
    list.push_back({{"name", p.name}, {"sha256", p.sha256}, {"bytes", p.bytes}, {"since_ms", p.since_ms}});
  const std::string body = wire::encode_json({{"programs", std::move(list)}});
  if (body.size() <= wire::kMaxControlBytes)
    connection_->send(Type::census, 0, body);
  else
    log::warning("link: {} resident programs are too many for one census", parts_->memory.census().size());
}

void Session::sample_trail() {
  const operation::Live live = parts_->host.live();
  if (live.absolute == last_position_) return;
  last_position_ = live.absolute;
  json point = json::array();
  for (std::size_t i = 0; i < std::min(live.axes.size(), machine::kMaxAxes); ++i)
    point.push_back(live.absolute[i]);
  if (trail_.size() >= kMaxTrail) trail_.erase(trail_.begin());
  trail_.push_back(std::move(point));
}

void Session::send_live() {
  if (connection_->waiting_bytes() > kLiveWaiting) return;
  json live = live_to_json(parts_->host.live(), parts_->host.selected_sha256());
  live["trail"] = std::exchange(trail_, json::array());
  live["drip"] = nullptr;
  if (!parts_->transfers.drips.empty()) {
    const auto& [id, drip] = *parts_->transfers.drips.begin();
    const auto state = drip.feed->state();
    live["drip"] = {{"transfer", id},
                    {"bytes", state.received},
                    {"total", drip.feed->announced().bytes},
                    {"buffered", state.buffered}};
  }
  connection_->send(Type::live, 0, wire::encode_json(live));
}

// ---- commands

void Session::answer(std::uint64_t id, bool accepted, std::string reason) {
  connection_->send(Type::command_result, 0,
                    wire::encode(wire::CommandResult{id, accepted, std::move(reason)}));
}

void Session::on_command(const wire::Command& command) {
  operation::CommandResult outcome;
  operation::Action action{};
  if (command.action == "select")
    outcome = parts_->host.select(command.name, command.user);
  else if (!action_from_name(command.action, action))
    outcome = {false, "unknown_action"};
  else
    outcome = parts_->host.command({action, operation::Origin::network, command.value}, command.user);
  answer(command.id, outcome.accepted, outcome.reason);
}

// ---- certificate

void Session::maybe_renew() {
  const auto info = wire::read_certificate(parts_->identity.credentials().certificate_pem);
  if (!wire::due_for_renewal(info, now_ms() / 1000)) return;
  auto [key, request] = wire::make_key_and_request(info.common_name);
  renewal_key_ = std::move(key);
  connection_->send(Type::renew, 0, wire::encode(wire::Enrol{"", request}));
}

void Session::on_renewed(const wire::Enrolled& enrolled) {
  if (renewal_key_.empty()) return;
  try {
    const auto info = wire::read_certificate(enrolled.certificate_pem);
    if (info.common_name !=
        wire::read_certificate(parts_->identity.credentials().certificate_pem).common_name)
      return log::error("link: the renewed certificate is for {}, not taken", info.common_name);
    parts_->identity.store_renewed(
        {std::exchange(renewal_key_, {}), enrolled.certificate_pem, parts_->identity.credentials().ca_pem});
    connection_->send(Type::certificate_stored, 0, wire::encode(wire::CertificateStored{info.serial_hex}));
  } catch (const wire::CertificateError& bad) {
    log::error("link: the renewed certificate cannot be used: {}", bad.what());
  }
}

}  // namespace headstock::link
