// The terminal's own XON/XOFF as the other side: not our code answers our DC1 and DC3, but the kernel's line
// discipline.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <random>
#include <thread>

#include "protocol/serial/port/line.hpp"
#include "protocol/serial/protocols.hpp"

namespace headstock::serial {
namespace {

using namespace std::chrono_literals;
namespace asio = boost::asio;

/// A cable: a TCP connection on our side, a terminal with IXON on the other.
class Cable {
 public:
  Cable() : acceptor_(io_, {asio::ip::address_v4::loopback(), 0}) {
    // What lies in the cable is bounded by the socket's buffers, however seldom a thread gets to run.
    acceptor_.set_option(asio::socket_base::send_buffer_size(4'096));
    termios settings{};
    ::cfmakeraw(&settings);
    settings.c_iflag |= IXON;
    settings.c_cc[VSTART] = 0x11;
    settings.c_cc[VSTOP] = 0x13;
    settings.c_cc[VMIN] = 1;
    EXPECT_EQ(::openpty(&master_, &terminal, nullptr, &settings, nullptr), 0);
    thread_ = std::thread([this] { carry(); });
  }
  ~Cable() {
    end_ = true;
    thread_.join();
    ::close(master_);
    ::close(terminal);
  }
  PortAddress address() const {
    return *address_of("tcp://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()));
  }

  int terminal = -1;                          ///< the other side's device
  std::atomic<std::size_t> dc1{0}, dc3{0};  ///< that went to the terminal

 private:
  void pass(int from, int to) {
    char piece[64];
    const auto count = ::read(from, piece, sizeof piece);
    if (to == master_ && count > 0) {
      dc1 += static_cast<std::size_t>(std::count(piece, piece + count, '\x11'));
      dc3 += static_cast<std::size_t>(std::count(piece, piece + count, '\x13'));
    }
    for (ssize_t done = 0; done < count;) {
      const auto wrote = ::write(to, piece + done, static_cast<std::size_t>(count - done));
      if (wrote < 0) return;
      done += wrote;
    }
  }
  void carry() {
    asio::ip::tcp::socket socket(io_);
    acceptor_.accept(socket);
    pollfd both[] = {{socket.native_handle(), POLLIN, 0}, {master_, POLLIN, 0}};
    while (!end_) {
      if (::poll(both, 2, 20) <= 0) continue;
      if ((both[0].revents & (POLLHUP | POLLERR)) != 0) return;
      if ((both[0].revents & POLLIN) != 0) pass(both[0].fd, master_);
      if ((both[1].revents & POLLIN) != 0) pass(master_, both[0].fd);
    }
  }

  asio::io_context io_;
  asio::ip::tcp::acceptor acceptor_;
  int master_ = -1;
  std::atomic<bool> end_{false};
  std::thread thread_;
};

template <class Condition>
bool until(asio::io_context& io, Condition condition) {
  const auto limit = Clock::now() + 60s;
  while (!condition() && Clock::now() < limit) {
    io.run_for(10ms);
    io.restart();
  }
  return condition();
}

TEST(KernelHandshake, TheTerminalStopsAndContinuesUs) {
  Cable cable;
  asio::io_context io;
  auto settings = default_settings("xon-xoff");
  settings.line.baud = 115'200;
  Line line(io.get_executor(), cable.address(), settings.line, {});
  line.open();
  ASSERT_TRUE(until(io, [&] { return line.is_open(); }));
  std::string text;
  while (text.size() < 20'000) text += "N" + std::to_string(text.size()) + " X1\n";
  std::string read;
  std::thread control([&] {
    std::mt19937 random(5);
    char piece[32];
    while (read.size() < text.size()) {
      const auto count = ::read(cable.terminal, piece, 1 + random() % sizeof piece);
      if (count <= 0) return;
      read.append(piece, static_cast<std::size_t>(count));
      if (random() % 40 != 0) continue;
      // The terminal sends its STOP character, later its START character.
      if (::tcflow(cable.terminal, TCIOFF) != 0) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % 20));
      if (::tcflow(cable.terminal, TCION) != 0) return;
    }
  });
  SendReport report;
  line.send(send_rules(settings), text_source(text), [&](const SendReport& now) { report = now; });
  EXPECT_TRUE(until(io, [&] { return report.over(); }));
  control.join();
  EXPECT_EQ(report.state, Sender::State::done) << report.reason;
  EXPECT_EQ(read, text);
  EXPECT_GT(report.counters.stops, 10u);
  EXPECT_EQ(report.counters.unexpected, 0u);
}

TEST(KernelHandshake, OurDc3StopsTheTerminalsOutput) {
  Cable cable;
  asio::io_context io;
  const auto settings = default_settings("xon-xoff");
  Line line(io.get_executor(), cable.address(), settings.line, {});
  line.open();
  ASSERT_TRUE(until(io, [&] { return line.is_open(); }));
  std::string text = "%\n";
  while (text.size() < 1'500'000) text += "N" + std::to_string(text.size()) + " X1\n";
  text += "%\n";
  std::string data;
  std::size_t backlog = 0;
  bool writing = false;
  auto rules = receive_rules(settings);
  rules.backlog_high = 4'000;
  rules.backlog_low = 500;
  rules.quiet_after_percent = 50ms;
  ReceiveReport report;
  // A disk that begins to write when its buffer is full and empties it whole: 50,000 bytes whenever it is looked at.
  line.receive(
      rules,
      [&](std::string_view piece) {
        data += piece;
        backlog += piece.size();
        writing = writing ? backlog > 0 : backlog >= rules.backlog_high;
        if (piece.empty() && writing) backlog -= std::min<std::size_t>(backlog, 50'000);
        return backlog;
      },
      [&](const ReceiveReport& now) { report = now; });
  std::thread control([&] {
    for (std::size_t at = 0; at < text.size();) {
      const auto wrote = ::write(cable.terminal, text.data() + at, text.size() - at);
      if (wrote <= 0) return;
      at += static_cast<std::size_t>(wrote);
    }
  });
  EXPECT_TRUE(until(io, [&] { return report.over(); }));
  control.join();
  EXPECT_EQ(report.state, Receiver::State::done) << report.reason;
  EXPECT_EQ(data, text);
  EXPECT_GE(cable.dc3, 2u);
  EXPECT_TRUE(until(io, [&] { return cable.dc1 == cable.dc3; })) << "the other side is never left stopped";
}

}  // namespace
}  // namespace headstock::serial
