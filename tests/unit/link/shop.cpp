#include "tests/unit/link/shop.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/write.hpp>
#include <charconv>
#include <string_view>

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
#ifdef __SANITIZE_THREAD__
  constexpr auto patience = 300s;  // everything takes ten times as long
#else
  constexpr auto patience = 30s;
#endif
  const auto limit = std::chrono::steady_clock::now() + patience;
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

// Digits go straight into the text: it is often made while a link is up, which nobody runs meanwhile, and a link that
// is silent for six seconds is lost. (Strings added to each other took five for 12 MB under the thread sanitizer.)
std::string program_text(std::size_t bytes, unsigned seed) {
  std::mt19937 random(seed);
  const std::string_view head = "%\nO1000\n";
  std::string text(bytes + 64, ' ');
  char* at = std::copy(head.begin(), head.end(), text.data());
  const auto word = [&at](std::string_view before, std::size_t number) {
    at = std::copy(before.begin(), before.end(), at);
    at = std::to_chars(at, at + 20, number).ptr;
  };
  const auto written = [&] { return static_cast<std::size_t>(at - text.data()); };
  while (written() < bytes) {
    word("N", written());
    word(" G1 X", random() % 100'000);
    word(". Z-", random() % 1000);
    at = std::copy_n(".\n", 2, at);
  }
  text.resize(bytes);
  return text;
}

}  // namespace headstock::testing_support
