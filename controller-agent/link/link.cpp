#include "link/link.hpp"

#include <algorithm>
#include <atomic>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <mutex>
#include <random>

#include "link/session.hpp"
#include "protocol/process/log.hpp"
#include "protocol/wire/digest.hpp"
#include "protocol/wire/tls.hpp"

namespace headstock::link {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using std::chrono::milliseconds;
using wire::Type;
constexpr auto kAsTuple = asio::as_tuple(asio::use_awaitable);
constexpr milliseconds kConnectLimit{10'000};

}  // namespace

struct Link::Impl : std::enable_shared_from_this<Impl> {
  Impl(asio::io_context& context, const LinkOptions& options, LinkHost& host, Spool& spool, ProgramMemory& memory)
      : io(context),
        parts(new LinkParts{options,
                            host,
                            spool,
                            memory,
                            Identity(options.pki_folder),
                            {},
                            wire::random_hex(8),
                            false,
                            false,
                            {},
                            {}}),
        pause(context.get_executor()) {}

  asio::io_context& io;
  std::shared_ptr<LinkParts> parts;
  wire::Signal pause;
  std::shared_ptr<wire::Connection> connection;
  std::shared_ptr<Session> session;
  std::unique_ptr<asio::ssl::context> tls;
  std::minstd_rand random{std::random_device{}()};
  milliseconds back_off{0};
  std::atomic_flag drips_posted;

  mutable std::mutex status_mutex;
  LinkStatus status;

  void start();
  asio::awaitable<void> run();
  asio::awaitable<bool> one_connection();
  asio::awaitable<std::shared_ptr<wire::Connection>> connect();
  asio::awaitable<void> enrol();
  void show(bool connected, std::string detail);
  /// Runs `call` on the link's thread, if there is still one.
  template <class Call>
  void post(Call call) {
    asio::post(io, [weak = weak_from_this(), call] {
      const auto self = weak.lock();
      if (self && !self->parts->stopped) call(*self);
    });
  }
};

void Link::Impl::show(bool connected, std::string detail) {
  const std::scoped_lock lock(status_mutex);
  if (status.detail != detail) {
    if (connected)
      log::info("link: {}", detail);
    else
      log::warning("link: {}", detail);
  }
  status.connected = connected;
  status.detail = std::move(detail);
  if (connected) ++status.connections;
}

void Link::Impl::start() {
  const std::weak_ptr<Impl> weak = weak_from_this();
  parts->wake_drips = [weak] {
    const auto self = weak.lock();
    // Once on its way is enough: the interpreter's thread may call for every block.
    if (!self || self->drips_posted.test_and_set()) return;
    self->post([](Impl& impl) {
      impl.drips_posted.clear();
      if (impl.session) impl.session->drips_changed();
    });
  };
  parts->wake_requests = [weak] {
    if (const auto self = weak.lock())
      self->post([](Impl& impl) {
        if (impl.session) impl.session->requests_changed();
      });
  };
  // M198 gets its programs from the server, and from nowhere else: a resident program of the same number may be another.
  parts->memory.on_external([weak](std::uint32_t number) -> std::unique_ptr<program::Source> {
    const auto self = weak.lock();
    return self ? self->parts->requests.open("O" + std::to_string(number)) : nullptr;
  });
  parts->spool.on_commit([weak] {
    if (const auto self = weak.lock())
      self->post([](Impl& impl) {
        if (impl.session) impl.session->events_committed();
      });
  });
  parts->memory.on_change([weak] {
    if (const auto self = weak.lock())
      self->post([](Impl& impl) {
        if (impl.session) impl.session->memory_changed();
      });
  });
  asio::co_spawn(
      io, [self = shared_from_this()] { return self->run(); }, asio::detached);
}

asio::awaitable<void> Link::Impl::run() {
  const auto self = shared_from_this();
  while (!parts->stopped) {
    bool welcomed = false;
    std::string failure;
    try {
      if (!parts->identity.enrolled()) co_await enrol();
      if (parts->identity.enrolled() && !parts->stopped) welcomed = co_await one_connection();
    } catch (const std::exception& error) {
      failure = error.what();
    }
    if (connection) connection->close("ended");
    connection.reset();
    session.reset();
    if (parts->stopped || parts->leaving) break;
    if (!failure.empty()) show(false, failure);
    // Half of the wait is chance, so that a hall of machines does not come back in one instant.
    const LinkOptions& options = parts->options;
    back_off = welcomed ? options.reconnect_min
                        : std::clamp(back_off * 2, options.reconnect_min, options.reconnect_max);
    const auto half = static_cast<long>(back_off.count() / 2);
    const auto until = std::chrono::steady_clock::now() +
                       milliseconds(half + std::uniform_int_distribution<long>(0, half)(random));
    while (!parts->stopped && std::chrono::steady_clock::now() < until)
      co_await pause.wait_for(std::chrono::ceil<milliseconds>(until - std::chrono::steady_clock::now()));
  }
}

asio::awaitable<std::shared_ptr<wire::Connection>> Link::Impl::connect() {
  const LinkOptions& options = parts->options;
  tcp::resolver resolver(io);
  const auto [unresolved, endpoints] =
      co_await resolver.async_resolve(options.host, std::to_string(options.port), kAsTuple);
  const std::string where = options.host + ':' + std::to_string(options.port);
  if (unresolved) throw std::runtime_error("server " + where + ": " + unresolved.message());
  tcp::socket socket(io);
  // A server that is off does not answer at all: not minutes of TCP's own patience.
  asio::steady_timer deadline(io, kConnectLimit);
  deadline.async_wait([&socket](const boost::system::error_code& error) {
    boost::system::error_code ignored;
    if (!error) socket.close(ignored);
  });
  const auto [refused, endpoint] = co_await asio::async_connect(socket, endpoints, kAsTuple);
  deadline.cancel();
  if (refused) throw std::runtime_error("server " + where + " cannot be reached: " + refused.message());
  co_return std::make_shared<wire::Connection>(std::move(socket), *tls);
}

asio::awaitable<bool> Link::Impl::one_connection() {
  const Credentials& credentials = parts->identity.credentials();
  tls = std::make_unique<asio::ssl::context>(
      wire::agent_context(credentials.ca_pem, credentials.certificate_pem, credentials.key_pem));
  connection = co_await connect();
  if (parts->stopped) co_return false;
  const bool secure = co_await connection->handshake(asio::ssl::stream_base::client, kConnectLimit);
  bool welcomed = false;
  if (secure && !parts->stopped) {
    {
      const std::scoped_lock lock(status_mutex);
      status.machine = wire::machine_of_name(wire::read_certificate(credentials.certificate_pem).common_name);
    }
    const auto current = std::make_shared<Session>(parts, connection);
    session = current;
    current->on_welcome([this] { show(true, "connected"); });
    welcomed = co_await current->run();
    if (!welcomed && parts->identity.trying_renewed()) parts->identity.drop_renewed();
  }
  if (parts->stopped) co_return welcomed;
  const std::string reason = connection->reason();
  show(false, reason);
  if (welcomed) parts->host.link_lost(reason);
  co_return welcomed;
}

asio::awaitable<void> Link::Impl::enrol() {
  const auto token = wire::parse_token(parts->options.enrolment_token);
  if (!token)
    throw std::runtime_error(
        "this machine is not enrolled: a token from the server's machine page is needed");
  tls = std::make_unique<asio::ssl::context>(wire::enrolment_context());
  connection = co_await connect();
  if (!co_await connection->handshake(asio::ssl::stream_base::client, kConnectLimit))
    throw std::runtime_error("enrolment: " + connection->reason());
  std::string ca_pem;
  if (const std::string wrong =
          wire::check_enrolment_server(connection->tls(), token->ca_fingerprint, ca_pem);
      !wrong.empty())
    throw std::runtime_error("enrolment: " + wrong);
  const auto [key, request] = wire::make_key_and_request("agent");
  connection->send(Type::enrol, 0, wire::encode(wire::Enrol{token->secret, request}));
  wire::Frame frame;
  while (co_await connection->receive(frame)) {
    if (frame.type == Type::refuse) {
      wire::Refuse refuse;
      const std::string wrong = wire::decode(frame.body, refuse);
      throw std::runtime_error("enrolment refused: " + (wrong.empty() ? refuse.reason : wrong));
    }
    if (frame.type != Type::enrolled) continue;
    wire::Enrolled enrolled;
    if (const std::string wrong = wire::decode(frame.body, enrolled); !wrong.empty())
      throw std::runtime_error("enrolment: " + wrong);
    parts->identity.store({key, enrolled.certificate_pem, ca_pem});
    log::info("link: enrolled as machine {} \"{}\"", enrolled.machine, enrolled.machine_name);
    connection->close("enrolled");
    co_return;
  }
  throw std::runtime_error("enrolment: " + connection->reason());
}

Link::Link(asio::io_context& io, LinkOptions options, LinkHost& host, Spool& spool, ProgramMemory& memory) {
  if (!options.enrolment_token.empty() && !wire::parse_token(options.enrolment_token))
    throw std::runtime_error(
        "the enrolment token is not one (HS1-…-…): copy it again from the server's machine page");
  impl_ = std::make_shared<Impl>(io, options, host, spool, memory);
}

Link::~Link() {
  if (!impl_->parts->stopped) stop();
}

void Link::start() {
  impl_->start();
}

bool Link::request(const std::string& name) {
  return impl_->parts->requests.ask(name);
}

bool Link::say_good_bye() {
  const auto& connection = impl_->connection;
  if (!connection || !connection->open() || !status().connected) return false;
  impl_->parts->leaving = true;
  connection->send(Type::refuse, 0, wire::encode(wire::Refuse{"shutdown", "", {wire::kVersion}}));
  connection->finish("shutdown");
  return true;
}

bool Link::connection_open() const {
  return impl_->connection != nullptr;
}

void Link::stop() {
  impl_->parts->stopped = true;
  impl_->parts->spool.on_commit({});
  impl_->parts->memory.on_change({});
  impl_->parts->memory.on_external({});
  impl_->parts->requests.link_is_lost();
  if (impl_->connection) impl_->connection->close("stopped");
  impl_->pause.notify();
}

LinkStatus Link::status() const {
  const std::scoped_lock lock(impl_->status_mutex);
  LinkStatus status = impl_->status;
  status.events_pending = impl_->parts->spool.pending();
  return status;
}

}  // namespace headstock::link
