#include "server/gateway/gateway.hpp"

#include <algorithm>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "protocol/process/log.hpp"
#include "server/gateway/gateway_impl.hpp"

namespace headstock::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using nlohmann::json;
using wire::Type;

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
      log::error("gateway: cannot accept a connection: {}", error.message());
      pause.expires_after(std::chrono::milliseconds(100));
      co_await pause.async_wait(kAsTuple);
      continue;
    }
    if (connections >= settings.connection_limit) {
      log::error("gateway: more than {} connections, the newest is closed", settings.connection_limit);
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
      log::error("gateway: {}", error.what());
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

}  // namespace headstock::server
