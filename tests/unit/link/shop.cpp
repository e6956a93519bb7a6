#include "tests/unit/link/shop.hpp"

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/write.hpp>

namespace headstock::testing_support {
namespace {

using asio::ip::tcp;
using namespace std::chrono_literals;
constexpr auto kAsTuple = asio::as_tuple(asio::use_awaitable);

}  // namespace

asio::awaitable<server::MachineAnswer> FakeFleet::program_requested(std::int64_t machine, std::string name) {
  asked.push_back(name);
  const auto found = library.find(name);
  if (found == library.end()) co_return server::MachineAnswer{false, "not_found"};
  const auto text = std::make_shared<const std::string>(found->second);
  const std::uint64_t transfer = 1'000 + asked.size();
  co_return co_await gateway->drip(transfer, machine, name, wire::sha256_hex(*text), std::make_shared<TextBlob>(text));
}

struct CuttingProxy::Pair {
  explicit Pair(asio::io_context& io) : near(io), far(io) {}
  tcp::socket near, far;
  std::optional<std::size_t> left;
  void close() {
    boost::system::error_code ignored;
    near.close(ignored);
    far.close(ignored);
  }
};

CuttingProxy::CuttingProxy(asio::io_context& io, std::uint16_t to)
    : io_(io), acceptor_(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0)), to_(to) {
  asio::co_spawn(io_, accept_loop(), asio::detached);
}

CuttingProxy::~CuttingProxy() {
  *alive_ = false;
  boost::system::error_code ignored;
  acceptor_.close(ignored);
  cut_all();
}

void CuttingProxy::cut_all() {
  for (const auto& weak : pairs_)
    if (const auto pair = weak.lock()) pair->close();
  pairs_.clear();
}

asio::awaitable<void> CuttingProxy::accept_loop() {
  const auto alive = alive_;
  while (*alive) {
    auto [error, socket] = co_await acceptor_.async_accept(kAsTuple);
    if (!*alive || error) co_return;
    ++accepted;
    const auto pair = std::make_shared<Pair>(io_);
    pair->near = std::move(socket);
    const auto [refused] =
        co_await pair->far.async_connect(tcp::endpoint(asio::ip::address_v4::loopback(), to_), kAsTuple);
    if (!*alive) co_return;
    if (refused) continue;
    pair->left = allowance ? allowance() : std::nullopt;
    pairs_.push_back(pair);
    asio::co_spawn(io_, pump(this, pair, true, alive), asio::detached);
    asio::co_spawn(io_, pump(this, pair, false, alive), asio::detached);
  }
}

asio::awaitable<void> CuttingProxy::pump(CuttingProxy* proxy, std::shared_ptr<Pair> pair, bool up,
                                         std::shared_ptr<bool> alive) {
  tcp::socket& from = up ? pair->near : pair->far;
  tcp::socket& to = up ? pair->far : pair->near;
  std::vector<char> buffer(16 << 10);
  asio::steady_timer pause(from.get_executor());
  for (;;) {
    while (*alive && proxy->stalled && from.is_open()) {
      pause.expires_after(5ms);
      co_await pause.async_wait(kAsTuple);
    }
    auto [error, bytes] = co_await from.async_read_some(asio::buffer(buffer), kAsTuple);
    if (error || !*alive) break;
    bool cut = false;
    if (pair->left) {
      cut = bytes >= *pair->left;
      bytes = std::min(bytes, *pair->left);
      *pair->left -= bytes;
    }
    const auto [failed, written] =
        co_await asio::async_write(to, asio::buffer(buffer.data(), bytes), kAsTuple);
    if (cut && *alive) ++proxy->cuts;
    if (failed || cut) break;
  }
  pair->close();
}

link::LinkOptions Agent::options(std::uint16_t port) const {
  link::LinkOptions options;
  options.port = port;
  options.pki_folder = pki;
  options.machine_name = "lathe";
  options.profile = "fanuc-0i-t";
  options.axes = {"X", "Z"};
  options.reconnect_min = 5ms;
  options.reconnect_max = 20ms;
  return options;
}

void Agent::connect(asio::io_context& io, link::LinkOptions with) {
  link = std::make_unique<link::Link>(io, std::move(with), machine, spool, memory);
  link->start();
}

Shop::Shop() {
  start_gateway();
}

Shop::~Shop() {
  stop_gateway();
}

server::GatewayOptions Shop::gateway_options() const {
  server::GatewayOptions options;
  options.port = 0;
  options.pki_folder = (folder.path() / "server-pki").string();
  return options;
}

void Shop::start_gateway() {
  gateway = std::make_unique<server::Gateway>(io, gateway_options(), fleet);
  gateway->start();
  fleet.gateway = gateway.get();
}

void Shop::stop_gateway() {
  if (gateway) gateway->stop();
  gateway.reset();
}

std::string Shop::token_for(std::int64_t machine) {
  const std::string secret = wire::make_secret();
  fleet.tokens[secret] = machine;
  return wire::format_token({secret, gateway->ca_fingerprint()});
}

bool Shop::until(const std::function<bool()>& condition) {
  const auto limit = std::chrono::steady_clock::now() + 30s;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > limit) return false;
    io.restart();
    io.run_one_for(5ms);
  }
  return true;
}

void Shop::run_for(std::chrono::milliseconds time) {
  io.restart();
  io.run_for(time);
}

std::string program_text(std::size_t bytes, unsigned seed) {
  std::mt19937 random(seed);
  std::string text = "%\nO1000\n";
  text.reserve(bytes + 64);
  while (text.size() < bytes)
    text += "N" + std::to_string(text.size()) + " G1 X" + std::to_string(random() % 100'000) + ". Z-" +
            std::to_string(random() % 1000) + ".\n";
  text.resize(bytes);
  return text;
}

}  // namespace headstock::testing_support
