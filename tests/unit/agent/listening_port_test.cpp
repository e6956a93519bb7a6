// DNC software that connects to the machine, over real sockets.
#include "agent/listening_port.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>

namespace headstock::agent {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using namespace std::chrono_literals;

std::uint16_t free_port() {
  asio::io_context io;
  return tcp::acceptor(io, tcp::endpoint(asio::ip::address_v4::loopback(), 0)).local_endpoint().port();
}

struct Listening : ::testing::Test, serial::PortListener {
  asio::io_context io;
  std::uint16_t number = free_port();
  std::unique_ptr<serial::Port> port = make_listening_port(io.get_executor(), "127.0.0.1", number);
  std::string received, closed;
  bool open = false, wanted = true;
  std::size_t want_until = ~std::size_t{0}, most_after_stop = 0;
  int faults = 0, writable = 0;

  void on_open() override { open = true; }
  void on_bytes(std::string_view bytes) override {
    received += bytes;
    if (!wanted) most_after_stop = std::max(most_after_stop, received.size() - want_until);
    if (wanted && received.size() >= want_until) port->set_rts(wanted = false);
  }
  void on_fault(serial::Fault fault) override { faults += fault == serial::Fault::disconnected; }
  void on_signals(const serial::Signals&) override {}
  void on_writable() override { ++writable; }
  void on_closed(const std::string& reason, const std::string&) override { closed = reason; }

  template <class Condition>
  bool until(Condition condition) {
    const auto limit = std::chrono::steady_clock::now() + 30s;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > limit) return false;
      io.restart();
      io.run_one_for(5ms);
    }
    return true;
  }
  void start() {
    port->open(*this);
    ASSERT_TRUE(until([&] { return open; }));
  }
  tcp::socket connect() {
    tcp::socket socket(io);
    socket.connect(tcp::endpoint(asio::ip::address_v4::loopback(), number));
    return socket;
  }
};

TEST_F(Listening, WhatIsNotWantedStaysWithTheSender) {
  start();
  port->set_rts(wanted = false);
  std::string text;
  for (int i = 0; text.size() < 12'000'000; ++i) text += "N" + std::to_string(i) + "\n";
  auto peer = connect();
  peer.non_blocking(true);
  std::size_t sent = 0;
  const auto push = [&] {
    boost::system::error_code error;
    if (sent < text.size())
      sent += peer.write_some(asio::buffer(text.data() + sent, text.size() - sent), error);
  };
  until([&, rounds = 0]() mutable {
    push();
    return ++rounds > 200;
  });
  EXPECT_EQ(received, "") << "nothing was wanted";
  EXPECT_LT(sent, text.size()) << "TCP holds the sender";
  for (std::size_t goal = 0; received.size() < text.size();) {
    goal = want_until = received.size() + 400'000;
    port->set_rts(wanted = true);
    ASSERT_TRUE(until([&] {
      push();
      return !wanted || received.size() == text.size();
    }));
    ASSERT_LE(most_after_stop, 8u);
    ASSERT_LE(received.size(), goal + 8);
  }
  EXPECT_TRUE(received == text);
}

TEST_F(Listening, OnePeerAtATimeAndTheNextOneAfterIt) {
  start();
  auto first = connect();
  ASSERT_TRUE(until([&] { return writable == 1; }));
  auto second = connect();
  char byte;
  bool turned_away = false;
  second.async_read_some(asio::buffer(&byte, 1),
                         [&](auto error, std::size_t) { turned_away = static_cast<bool>(error); });
  ASSERT_TRUE(until([&] { return turned_away; }));
  asio::write(first, asio::buffer("O1\n", 3));
  ASSERT_TRUE(until([&] { return received == "O1\n"; }));
  EXPECT_EQ(port->write("\x11"), 1u);
  EXPECT_EQ(asio::read(first, asio::buffer(&byte, 1)), 1u);
  EXPECT_EQ(byte, '\x11');
  first.close();
  ASSERT_TRUE(until([&] { return faults == 1; }));
  EXPECT_EQ(port->write("\x11"), 0u) << "nobody there";
  auto third = connect();
  ASSERT_TRUE(until([&] { return writable == 2; }));
  asio::write(third, asio::buffer("O2\n", 3));
  ASSERT_TRUE(until([&] { return received == "O1\nO2\n"; }));
}

TEST_F(Listening, AnAddressThatIsTakenIsSaid) {
  start();
  auto other = make_listening_port(io.get_executor(), "127.0.0.1", number);
  struct : serial::PortListener {
    std::string reason;
    void on_open() override {}
    void on_bytes(std::string_view) override {}
    void on_fault(serial::Fault) override {}
    void on_signals(const serial::Signals&) override {}
    void on_writable() override {}
    void on_closed(const std::string& why, const std::string&) override { reason = why; }
  } told;
  other->open(told);
  ASSERT_TRUE(until([&] { return !told.reason.empty(); }));
  EXPECT_EQ(told.reason, "port_in_use");
}

}  // namespace
}  // namespace headstock::agent
