#include "server/gateway/gateway.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "protocol/wire/certificates.hpp"
#include "protocol/wire/tls.hpp"
#include "server/gateway/agent_session.hpp"
#include "server/gateway/outgoing_transfer.hpp"

namespace headstock::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using nlohmann::json;
using wire::Type;
constexpr auto kAsTuple = asio::as_tuple(asio::use_awaitable);

/// A put whose machine does not come back is given up; its bytes stay there for the next attempt.
constexpr std::chrono::minutes kPutWaits{15};
/// The server's own certificate is looked at again this often.
constexpr std::chrono::hours kRenewalCheck{12};

json to_json(const wire::Hello& hello) {
  return {{"software", hello.software},         {"name", hello.name},
          {"profile", hello.profile},           {"axes", hello.axes},
          {"boot_id", hello.boot_id},           {"spool_id", hello.spool_id},
          {"acknowledged", hello.acknowledged}, {"memory_bytes", hello.memory_bytes},
          {"census_hash", hello.census_hash},   {"machine_toml", hello.machine_toml}};
}

}  // namespace

struct Gateway::Impl final : SessionOwner, std::enable_shared_from_this<Impl> {
  Impl(asio::io_context& context, GatewayOptions given, GatewayHost& the_host)
      : io(context),
        settings(std::move(given)),
        host_(the_host),
        authority(settings.pki_folder, settings.host_names),
        tls(wire::server_context(authority)),
        acceptor(context),
        renewal(context) {}

  asio::io_context& io;
  GatewayOptions settings;
  GatewayHost& host_;
  wire::Authority authority;
  asio::ssl::context tls;
  tcp::acceptor acceptor;
  asio::steady_timer renewal;
  bool stopped_ = false, leaving = false;
  std::size_t connections = 0;
  std::set<std::shared_ptr<AgentSession>> sessions;
  std::map<std::int64_t, std::shared_ptr<AgentSession>> machines;
  std::map<std::uint64_t, std::shared_ptr<OutgoingTransfer>> transfers;
  std::map<std::int64_t, std::shared_ptr<wire::Signal>> put_turns;
  std::set<std::int64_t> putting;

  void listen();
  asio::awaitable<void> accept_loop();
  asio::awaitable<void> renewal_loop();
  asio::awaitable<void> serve(std::shared_ptr<AgentSession> session);
  std::shared_ptr<OutgoingTransfer> add_transfer(std::uint64_t id, std::int64_t machine, const char* kind,
                                                 std::string name, std::string sha256,
                                                 std::shared_ptr<BlobReader> content);
  asio::awaitable<void> put_turn(std::int64_t machine);
  asio::awaitable<TransferState> put(std::uint64_t id, std::int64_t machine, std::string name,
                                     std::string sha256, std::shared_ptr<BlobReader> content);
  void stop();

  // ---- SessionOwner
  bool stopped() const override { return stopped_; }
  GatewayHost& host() override { return host_; }
  const GatewayOptions& options() const override { return settings; }
  wire::IssuedCertificate sign(const std::string& request, std::int64_t machine) override {
    return authority.sign(request, machine);
  }
  const std::string& ca_pem() const override { return authority.ca_pem(); }
  std::shared_ptr<AgentSession> session_of(std::int64_t machine) override {
    const auto found = machines.find(machine);
    return found != machines.end() && found->second->open() ? found->second : nullptr;
  }
  void greeted(const std::shared_ptr<AgentSession>& session, const wire::Hello& hello) override;
  void gone(const std::shared_ptr<AgentSession>& session) override;
  void on_credit(AgentSession& session, const wire::Frame& frame, const wire::Credit& credit) override;
  void on_result(AgentSession& session, const wire::TransferResult& result) override;
};

void Gateway::Impl::listen() {
  boost::system::error_code error;
  const auto address = asio::ip::make_address(settings.address, error);
  if (error) throw std::runtime_error("agents' address '" + settings.address + "' is not an IP address");
  const tcp::endpoint endpoint(address, settings.port);
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error)
    throw std::runtime_error("agents' port " + std::to_string(settings.port) + " on " + settings.address +
                             ": " + error.message());
}

asio::awaitable<void> Gateway::Impl::accept_loop() {
  const auto self = shared_from_this();
  asio::steady_timer pause(io);
  while (!stopped_ && !leaving) {
    auto [error, socket] = co_await acceptor.async_accept(kAsTuple);
    if (stopped_ || leaving) break;
    if (error) {
      // Out of descriptors, mostly: those who are connected go on, and room may come.
      spdlog::error("gateway: cannot accept a connection: {}", error.message());
      pause.expires_after(std::chrono::milliseconds(100));
      co_await pause.async_wait(kAsTuple);
      continue;
    }
    if (connections >= settings.connection_limit) {
      spdlog::error("gateway: more than {} connections, the newest is closed", settings.connection_limit);
      continue;
    }
    const auto connection = std::make_shared<wire::Connection>(std::move(socket), tls);
    const auto session = std::make_shared<AgentSession>(self, connection);
    asio::co_spawn(
        io, [self, session] { return self->serve(session); }, asio::detached);
  }
}

asio::awaitable<void> Gateway::Impl::serve(std::shared_ptr<AgentSession> session) {
  const auto self = shared_from_this();
  ++connections;
  sessions.insert(session);
  co_await session->run();
  sessions.erase(session);
  --connections;
}

asio::awaitable<void> Gateway::Impl::renewal_loop() {
  const auto self = shared_from_this();
  while (!stopped_) {
    renewal.expires_after(kRenewalCheck);
    co_await renewal.async_wait(kAsTuple);
    if (stopped_) break;
    try {
      authority = wire::Authority(settings.pki_folder, settings.host_names);
      tls = wire::server_context(authority);
    } catch (const std::exception& error) {
      spdlog::error("gateway: {}", error.what());
    }
  }
}

void Gateway::Impl::stop() {
  if (stopped_) return;
  stopped_ = true;
  boost::system::error_code ignored;
  acceptor.close(ignored);
  renewal.cancel();
  for (const auto& session : sessions) session->connection()->close("the server stops");
  // Sessions hold us and we hold them; when the loop never runs again, nobody else would undo that.
  machines.clear();
  sessions.clear();
  transfers.clear();
}

void Gateway::Impl::greeted(const std::shared_ptr<AgentSession>& session, const wire::Hello& hello) {
  const std::int64_t machine = session->machine();
  machines[machine] = session;
  host_.connected(machine, to_json(hello));
  const auto mine = transfers;  // ends of transfers change the table
  for (const auto& [id, transfer] : mine) {
    if (transfer->state().machine != machine || transfer->finished()) continue;
    const bool still_there = std::ranges::find(hello.transfers, id) != hello.transfers.end();
    if (!transfer->is_drip())
      transfer->open_on(session->connection(), session->next_stream());
    else if (!still_there)
      transfer->fail("machine_restarted");
    // A drip-feed the machine still has: it says where it stands with its next message.
  }
}

void Gateway::Impl::gone(const std::shared_ptr<AgentSession>& session) {
  const auto found = machines.find(session->machine());
  if (found == machines.end() || found->second != session) return;
  machines.erase(found);
  const auto mine = transfers;
  for (const auto& [id, transfer] : mine)
    if (transfer->state().machine == session->machine()) transfer->detach();
  if (!stopped_) host_.disconnected(session->machine(), session->connection()->reason());
}

void Gateway::Impl::on_credit(AgentSession& session, const wire::Frame& frame, const wire::Credit& credit) {
  const auto found = transfers.find(credit.transfer);
  if (found == transfers.end() || found->second->state().machine != session.machine() ||
      found->second->finished()) {
    session.connection()->send(Type::transfer_cancel, frame.stream,
                               wire::encode(wire::TransferCancel{credit.transfer, "unknown_transfer"}));
    return;
  }
  // A new stream number keeps late frames of an older connection apart.
  if (frame.type == Type::drip_resume)
    found->second->resume_on(session.connection(), frame.stream, credit);
  else
    found->second->on_credit(credit);
}

void Gateway::Impl::on_result(AgentSession& session, const wire::TransferResult& result) {
  const auto found = transfers.find(result.transfer);
  if (found != transfers.end() && found->second->state().machine == session.machine())
    found->second->on_result(result);
  session.connection()->send(Type::transfer_closed, 0,
                             wire::encode(wire::TransferCancel{result.transfer, ""}));
}

std::shared_ptr<OutgoingTransfer> Gateway::Impl::add_transfer(std::uint64_t id, std::int64_t machine,
                                                              const char* kind, std::string name,
                                                              std::string sha256,
                                                              std::shared_ptr<BlobReader> content) {
  TransferState state;
  state.id = id;
  state.machine = machine;
  state.kind = kind;
  state.sha256 = std::move(sha256);
  const auto changed = [weak = weak_from_this()](const TransferState& now) {
    const auto self = weak.lock();
    if (!self) return;
    const bool over = now.state == "done" || now.state == "failed" || now.state == "cancelled";
    const std::uint64_t ended = now.id;
    if (!self->stopped_) self->host_.transfer_changed(now);
    if (over) self->transfers.erase(ended);
  };
  const auto transfer = std::make_shared<OutgoingTransfer>(io.get_executor(), std::move(state),
                                                           std::move(name), std::move(content), changed);
  transfers[id] = transfer;
  return transfer;
}

/// One put a machine at a time; the others wait their turn.
asio::awaitable<void> Gateway::Impl::put_turn(std::int64_t machine) {
  const auto self = shared_from_this();
  auto& turn = put_turns[machine];
  if (!turn) turn = std::make_shared<wire::Signal>(io.get_executor());
  const auto signal = turn;
  while (putting.contains(machine) && !stopped_) co_await signal->wait();
  putting.insert(machine);
}

asio::awaitable<TransferState> Gateway::Impl::put(std::uint64_t id, std::int64_t machine, std::string name,
                                                  std::string sha256, std::shared_ptr<BlobReader> content) {
  const auto self = shared_from_this();
  TransferState refused;
  refused.id = id;
  refused.machine = machine;
  refused.kind = "put";
  refused.sha256 = sha256;
  refused.total = content->size();
  refused.state = "failed";
  if (transfers.contains(id))
    refused.reason = "busy";
  else if (!session_of(machine))
    refused.reason = "not_connected";
  if (!refused.reason.empty()) {
    host_.transfer_changed(refused);
    co_return refused;
  }
  refused.state = "queued";
  host_.transfer_changed(refused);
  co_await put_turn(machine);
  const auto transfer =
      add_transfer(id, machine, "put", std::move(name), std::move(sha256), std::move(content));
  if (const auto session = session_of(machine))
    transfer->open_on(session->connection(), session->next_stream());
  else
    transfer->fail("not_connected");

  std::weak_ptr<OutgoingTransfer> weak = transfer;
  auto watch = [self, weak]() -> asio::awaitable<void> {
    // Gives up a put that has waited too long for its machine.
    asio::steady_timer timer(self->io);
    auto waiting_since = std::chrono::steady_clock::now();
    while (true) {
      timer.expires_after(std::chrono::seconds(1));
      co_await timer.async_wait(kAsTuple);
      const auto watched = weak.lock();
      if (!watched || watched->finished() || self->stopped_) co_return;
      const auto now = std::chrono::steady_clock::now();
      if (watched->state().state != "waiting")
        waiting_since = now;
      else if (now - waiting_since > kPutWaits)
        watched->fail("link_lost");
    }
  };
  asio::co_spawn(io, watch, asio::detached);
  co_await transfer->ended();
  putting.erase(machine);
  if (const auto turn = put_turns.find(machine); turn != put_turns.end()) turn->second->notify();
  co_return transfer->state();
}

// ---- the public face

Gateway::Gateway(asio::io_context& io, GatewayOptions options, GatewayHost& host)
    : impl_(std::make_shared<Impl>(io, std::move(options), host)) {}
Gateway::~Gateway() {
  impl_->stop();
}

void Gateway::start() {
  impl_->listen();
  asio::co_spawn(
      impl_->io, [impl = impl_] { return impl->accept_loop(); }, asio::detached);
  asio::co_spawn(
      impl_->io, [impl = impl_] { return impl->renewal_loop(); }, asio::detached);
}

asio::awaitable<void> Gateway::shut_down(std::chrono::milliseconds patience) {
  const auto impl = impl_;
  impl->leaving = true;
  boost::system::error_code ignored;
  impl->acceptor.close(ignored);
  const auto everybody = impl->sessions;
  for (const auto& session : everybody)
    if (session->open()) session->refuse("shutdown");
  asio::steady_timer timer(impl->io);
  const auto until = std::chrono::steady_clock::now() + patience;
  while (!impl->machines.empty() && std::chrono::steady_clock::now() < until) {
    timer.expires_after(std::chrono::milliseconds(5));
    co_await timer.async_wait(kAsTuple);
  }
}

void Gateway::stop() {
  impl_->stop();
}

std::uint16_t Gateway::port() const {
  boost::system::error_code ignored;
  return impl_->acceptor.local_endpoint(ignored).port();
}

std::string Gateway::ca_fingerprint() const {
  return impl_->authority.ca_fingerprint();
}

bool Gateway::is_connected(std::int64_t machine) const {
  return impl_->session_of(machine) != nullptr;
}

void Gateway::drop(std::int64_t machine, const std::string& reason) {
  if (const auto session = impl_->session_of(machine)) session->refuse("dropped", reason);
}

asio::awaitable<MachineAnswer> Gateway::command(std::int64_t machine, std::string action, double value,
                                                std::string user) {
  const auto session = impl_->session_of(machine);
  if (!session) co_return MachineAnswer{false, "not_connected"};
  wire::Command command;
  command.action = std::move(action);
  command.value = value;
  command.user = std::move(user);
  co_return co_await session->ask(Type::command, std::move(command));
}

asio::awaitable<MachineAnswer> Gateway::select(std::int64_t machine, std::string name, std::string user) {
  const auto session = impl_->session_of(machine);
  if (!session) co_return MachineAnswer{false, "not_connected"};
  wire::Command command;
  command.action = "select";
  command.name = std::move(name);
  command.user = std::move(user);
  co_return co_await session->ask(Type::command, std::move(command));
}

asio::awaitable<MachineAnswer> Gateway::delete_program(std::int64_t machine, std::string name) {
  const auto session = impl_->session_of(machine);
  if (!session) co_return MachineAnswer{false, "not_connected"};
  wire::Command command;
  command.action = "delete";
  command.name = std::move(name);
  co_return co_await session->ask(Type::program_delete, std::move(command));
}

asio::awaitable<nlohmann::json> Gateway::write_data(std::int64_t machine, nlohmann::json write) {
  const auto session = impl_->session_of(machine);
  if (!session) co_return nlohmann::json{{"accepted", false}, {"reason", "not_connected"}};
  co_return co_await session->write_data(std::move(write));
}

asio::awaitable<TransferState> Gateway::put(std::uint64_t transfer, std::int64_t machine, std::string name,
                                            std::string sha256, std::shared_ptr<BlobReader> content) {
  return impl_->put(transfer, machine, std::move(name), std::move(sha256), std::move(content));
}

asio::awaitable<MachineAnswer> Gateway::drip(std::uint64_t transfer, std::int64_t machine, std::string name,
                                             std::string sha256, std::shared_ptr<BlobReader> content) {
  const auto impl = impl_;
  if (impl->transfers.contains(transfer)) co_return MachineAnswer{false, "busy"};
  const auto session = impl->session_of(machine);
  if (!session) co_return MachineAnswer{false, "not_connected"};
  const auto drip =
      impl->add_transfer(transfer, machine, "drip", std::move(name), std::move(sha256), std::move(content));
  drip->open_on(session->connection(), session->next_stream());
  co_await drip->answered();
  if (drip->accepted()) co_return MachineAnswer{true, ""};
  // The link went before an answer: whether the machine has it is not known, so it must not go on by itself.
  if (!drip->finished()) drip->fail("link_lost");
  co_return MachineAnswer{false, drip->state().reason};
}

void Gateway::offer_again(std::uint64_t transfer, std::int64_t machine, std::string name, std::string sha256,
                          std::shared_ptr<BlobReader> content) {
  const auto drip =
      impl_->add_transfer(transfer, machine, "drip", std::move(name), std::move(sha256), std::move(content));
  drip->wait_for_machine();
}

asio::awaitable<ProgramText> Gateway::get(std::int64_t machine, std::string name) {
  const auto session = impl_->session_of(machine);
  if (!session) {
    ProgramText none;
    none.reason = "not_connected";
    none.name = std::move(name);
    co_return none;
  }
  // Numbers of reads back are of this connection only; the top bit keeps them apart from the store's
  // transfers.
  const std::uint64_t transfer = (std::uint64_t{1} << 63) | session->next_stream();
  co_return co_await session->get(transfer, std::move(name));
}

bool Gateway::cancel(std::uint64_t transfer, const std::string& reason) {
  const auto found = impl_->transfers.find(transfer);
  if (found == impl_->transfers.end()) return false;
  const auto cancelled = found->second;
  cancelled->cancel(reason);
  return true;
}

}  // namespace headstock::server
