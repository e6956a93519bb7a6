// Who does not keep to the protocol loses the own connection, and nobody else's.
#include <gtest/gtest.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>

#include "link/identity.hpp"
#include "protocol/wire/connection.hpp"
#include "protocol/wire/frame.hpp"
#include "protocol/wire/messages.hpp"
#include "protocol/wire/tls.hpp"
#include "tests/unit/link/shop.hpp"

namespace headstock {
namespace {

using namespace testing_support;
using namespace std::chrono_literals;
using asio::ip::tcp;
using wire::Type;

constexpr auto kAsTuple = asio::as_tuple(asio::use_awaitable);

/// A neighbour that must not notice, and raw connections beside it.
struct Hostile : ::testing::Test {
  Shop shop;
  Agent neighbour{shop.folder.path() / "neighbour"};
  std::string certificate, key, ca;

  void SetUp() override {
    auto options = neighbour.options(shop.gateway->port());
    options.enrolment_token = shop.token_for(1);
    neighbour.connect(shop.io, options);
    ASSERT_TRUE(shop.until([&] { return neighbour.link->status().connected; }));
    const wire::Authority authority(shop.gateway_options().pki_folder, {});
    const auto made = wire::make_key_and_request("agent");
    const auto issued = authority.sign(made.request_pem, 2);
    shop.fleet.certificates[2] = issued.serial_hex;
    certificate = issued.pem;
    key = made.key_pem;
    ca = authority.ca_pem();
  }
  void TearDown() override {
    EXPECT_TRUE(neighbour.link->status().connected);
    EXPECT_EQ(neighbour.machine.losts, 0);
    const auto answer = shop.wait_for(shop.gateway->command(1, "feed_hold", 0, "li"));
    EXPECT_TRUE(answer.accepted) << answer.reason;
  }

  /// Sends raw bytes over plain TCP and waits until the server closes.
  bool closed_after_plain(const std::string& bytes) {
    bool closed = false;
    asio::co_spawn(
        shop.io,
        [&]() -> asio::awaitable<void> {
          tcp::socket socket(shop.io);
          co_await socket.async_connect({asio::ip::address_v4::loopback(), shop.gateway->port()},
                                        asio::use_awaitable);
          co_await asio::async_write(socket, asio::buffer(bytes), kAsTuple);
          std::array<char, 1024> buffer;
          for (boost::system::error_code error; !error;) {
            const auto [failed, got] = co_await socket.async_read_some(asio::buffer(buffer), kAsTuple);
            error = failed;
          }
          closed = true;
        },
        asio::detached);
    return shop.until([&] { return closed; });
  }

  struct Peer {
    asio::ssl::context context;
    std::shared_ptr<wire::Connection> connection;
    std::vector<std::pair<Type, std::string>> frames;
    bool closed = false;
  };
  /// Connects with the certificate of machine 2 and sends `bytes` after the handshake.
  std::shared_ptr<Peer> connect(bool greet) {
    auto peer = std::make_shared<Peer>(Peer{wire::agent_context(ca, certificate, key), nullptr, {}, false});
    asio::co_spawn(
        shop.io,
        [this, peer, greet]() -> asio::awaitable<void> {
          tcp::socket socket(shop.io);
          co_await socket.async_connect({asio::ip::address_v4::loopback(), shop.gateway->port()},
                                        asio::use_awaitable);
          peer->connection = std::make_shared<wire::Connection>(std::move(socket), peer->context);
          if (co_await peer->connection->handshake(asio::ssl::stream_base::client, 5s)) {
            wire::Hello hello;
            hello.versions = {1};
            hello.spool_id = "s";
            hello.census_hash = std::string(64, '0');
            if (greet) peer->connection->send(Type::hello, 0, wire::encode(hello));
            wire::Frame frame;
            while (co_await peer->connection->receive(frame))
              peer->frames.emplace_back(frame.type, std::string(frame.body));
          }
          peer->closed = true;
        },
        asio::detached);
    EXPECT_TRUE(shop.until([&] {
      return peer->closed ||
             (peer->connection && peer->connection->open() && (!greet || !peer->frames.empty()));
    }));
    return peer;
  }
  bool disconnected_for(const std::string& part) {
    return std::ranges::any_of(shop.fleet.disconnects,
                               [&](const auto& why) { return why.find(part) != std::string::npos; });
  }
};

TEST_F(Hostile, GarbageInsteadOfTls) {
  EXPECT_TRUE(closed_after_plain("GET / HTTP/1.1\r\nHost: x\r\n\r\n"));
  EXPECT_TRUE(closed_after_plain(std::string(10'000, '\0')));
  EXPECT_TRUE(closed_after_plain(std::string(10'000, '\xff')));
}

TEST_F(Hostile, FrameOfTwoGigabytes) {
  const auto peer = connect(true);
  std::string frame;
  wire::append_frame(frame, Type::live, 0, "x");
  frame[12] = '\x7f';
  frame[13] = frame[14] = frame[15] = '\xff';
  peer->connection->send_raw(frame);
  EXPECT_TRUE(shop.until([&] { return peer->closed; }));
  EXPECT_TRUE(shop.until([&] { return disconnected_for("a frame of 2147483647 bytes"); }));
}

TEST_F(Hostile, WrongCheckSumAndGarbageFrames) {
  auto peer = connect(true);
  std::string frame;
  wire::append_frame(frame, Type::live, 0, "xyz");
  frame.back() = 'q';
  peer->connection->send_raw(frame);
  EXPECT_TRUE(shop.until([&] { return disconnected_for("wrong check sum"); }));
  peer = connect(true);
  peer->connection->send_raw("garbage garbage garbage");
  EXPECT_TRUE(shop.until([&] { return disconnected_for("not a Headstock frame"); }));
}

TEST_F(Hostile, MessagesOutOfForm) {
  const std::pair<Type, std::string> bad[] = {
      {Type::events, wire::encode_json({{"events", json::array()}})},
      {Type::events, wire::encode_json({{"events", {{{"seq", 1}, {"at_ms", 0}}}}})},
      {Type::events, wire::encode_json({{"events",
                                         {{{"seq", 2}, {"at_ms", 0}, {"kind", "x"}},
                                          {{"seq", 1}, {"at_ms", 0}, {"kind", "x"}}}}})},
      {Type::census, wire::encode_json({{"programs", 3}})},
      {Type::live, std::string(100, '\x9f')},
      {Type::credit, "\xa0"},
      {Type::command_result, wire::encode_json(json::array())},
      {Type::transfer_result, std::string(200'000, '\x81')},
  };
  std::size_t disconnects = 0;
  for (const auto& [type, body] : bad) {
    const auto peer = connect(true);
    shop.run_for(60ms);  // past the limit on live messages
    peer->connection->send(type, 0, body);
    ASSERT_TRUE(shop.until([&] { return peer->closed; })) << static_cast<int>(type);
    ASSERT_TRUE(shop.until([&] { return shop.fleet.disconnects.size() > disconnects; }));
    ++disconnects;
  }
}

TEST_F(Hostile, ReportsWithoutEndWaitOnceWhileTheStoreIsBusy) {
  shop.fleet.census_held = true;
  const auto peer = connect(true);
  peer->connection->send(Type::census, 0, wire::encode_json({{"programs", json::array()}}));
  ASSERT_TRUE(shop.until([&] { return !shop.fleet.stored[2].empty(); }));
  for (int n = 1; n <= 1'000; ++n) {
    peer->connection->send(Type::census, 0, wire::encode_json({{"programs", json::array()}}));
    peer->connection->send(Type::data_report, 0,
                           wire::encode_json({{"sequence", n}, {"values", json::object()}}));
  }
  peer->connection->send(Type::ping, 0, wire::encode(wire::Ping{77, 0}));
  ASSERT_TRUE(shop.until([&] {
    return std::ranges::any_of(peer->frames, [](const auto& f) { return f.first == Type::pong; });
  }));
  shop.fleet.census_held = false;
  ASSERT_TRUE(shop.until([&] { return shop.fleet.stored[2].size() == 3; }));
  shop.run_for(60ms);
  EXPECT_EQ(shop.fleet.stored[2], (std::vector<std::string>{"census", "census", "report 1000"}));
  peer->connection->close("");
}

TEST_F(Hostile, UnknownTypesAreSkipped) {
  const auto peer = connect(true);
  peer->connection->send(static_cast<Type>(200), 0, "whatever");
  peer->connection->send(Type::ping, 0, wire::encode(wire::Ping{77, 0}));
  EXPECT_TRUE(shop.until([&] {
    return std::ranges::any_of(peer->frames, [](const auto& f) { return f.first == Type::pong; });
  }));
  peer->connection->close("");
}

TEST_F(Hostile, AnotherVersionIsToldWhatIsSpoken) {
  const auto peer = connect(false);
  std::string frame;
  wire::append_frame(frame, Type::hello, 0, "");
  frame[4] = 9;
  peer->connection->send_raw(frame);
  EXPECT_TRUE(shop.until([&] { return peer->closed; }));
  ASSERT_EQ(peer->frames.size(), 1u);
  wire::Refuse refuse;
  EXPECT_EQ(wire::decode(peer->frames[0].second, refuse), "");
  EXPECT_EQ(refuse.versions, std::vector<std::uint64_t>{1});
}

TEST_F(Hostile, SomethingElseThanHelloFirst) {
  const auto peer = connect(false);
  peer->connection->send(Type::live, 0, wire::encode_json(json::object()));
  EXPECT_TRUE(shop.until([&] { return peer->closed; }));
  EXPECT_EQ(shop.fleet.connects[2], 0);
  EXPECT_EQ(shop.fleet.live_count[2], 0);
}

TEST_F(Hostile, SilentConnectionsAreEnded) {
  auto options = shop.gateway_options();
  options.handshake_limit = 100ms;
  options.ping_interval = 30ms;
  options.silence_limit = 150ms;
  server::Gateway impatient(shop.io, options, shop.fleet);
  impatient.start();
  bool closed = false;
  asio::co_spawn(
      shop.io,
      [&]() -> asio::awaitable<void> {
        tcp::socket socket(shop.io);
        co_await socket.async_connect({asio::ip::address_v4::loopback(), impatient.port()},
                                      asio::use_awaitable);
        char byte;
        co_await socket.async_read_some(asio::buffer(&byte, 1), kAsTuple);
        closed = true;
      },
      asio::detached);
  EXPECT_TRUE(shop.until([&] { return closed; }));
}

TEST_F(Hostile, PeerThatDoesNotReadIsClosedWithBoundedMemory) {
  // A connection pair without a reader on the far side.
  const wire::Authority authority(shop.gateway_options().pki_folder, {});
  auto server_side = wire::server_context(authority);
  tcp::acceptor acceptor(shop.io, tcp::endpoint(asio::ip::address_v4::loopback(), 0));
  auto client_side = wire::agent_context(ca, certificate, key);
  std::shared_ptr<wire::Connection> writer, reader;
  int ready = 0;
  asio::co_spawn(
      shop.io,
      [&]() -> asio::awaitable<void> {
        writer = std::make_shared<wire::Connection>(co_await acceptor.async_accept(asio::use_awaitable),
                                                    server_side);
        ready += co_await writer->handshake(asio::ssl::stream_base::server, 5s);
      },
      asio::detached);
  asio::co_spawn(
      shop.io,
      [&]() -> asio::awaitable<void> {
        tcp::socket socket(shop.io);
        co_await socket.async_connect(acceptor.local_endpoint(), asio::use_awaitable);
        reader = std::make_shared<wire::Connection>(std::move(socket), client_side);
        ready += co_await reader->handshake(asio::ssl::stream_base::client, 5s);
      },
      asio::detached);
  ASSERT_TRUE(shop.until([&] { return ready == 2; }));
  const std::string body(60'000, 'x');
  std::size_t most = 0;
  ASSERT_TRUE(shop.until([&] {
    for (int n = 0; n < 10; ++n) writer->send(Type::live, 0, body);
    most = std::max(most, writer->waiting_bytes());
    return !writer->open();
  }));
  EXPECT_EQ(writer->reason(), "the other side does not read");
  EXPECT_LE(most, 9u << 20);
  reader->close("");
}

}  // namespace
}  // namespace headstock
