// Lines on real pseudo-terminals and sockets, against a simulated control.
#include "protocol/serial/port/line.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <cstdlib>
#include <optional>
#include <random>

#include "protocol/serial/protocols.hpp"
#include "simulated_control.hpp"

namespace headstock::serial {
namespace {

using namespace std::chrono_literals;
namespace asio = boost::asio;

/// A line with its own loop; waits for conditions, at most a minute.
struct Bench {
  explicit Bench(const PortAddress& address, const LinkSettings& the_settings = fast())
      : settings(the_settings) {
    LineCallbacks callbacks;
    callbacks.closed = [this](const std::string& reason, const std::string&) { closed = reason; };
    callbacks.idle_bytes = [this](std::string_view bytes) { idle += bytes; };
    line = std::make_unique<Line>(io.get_executor(), address, settings.line, std::move(callbacks));
    line->open();
  }
  static LinkSettings fast() {
    auto settings = default_settings("dc1-dc4");
    settings.line.baud = 921'600;
    settings.after_stop = 64;
    return settings;
  }
  template <class Condition>
  bool until(Condition condition) {
    const auto limit = Clock::now() + 60s;
    while (!condition() && Clock::now() < limit) {
      io.run_for(20ms);
      io.restart();
    }
    return condition();
  }
  bool ready() {
    return until([&] { return line->is_open() || closed; }) && line->is_open();
  }
  void send(const std::string& text) {
    report = {};
    line->send(send_rules(settings), text_source(text), [this](const SendReport& now) {
      report = now;
      io.stop();
    });
  }
  bool finished() {
    return until([&] { return report.over(); });
  }

  asio::io_context io;
  LinkSettings settings;
  std::unique_ptr<Line> line;
  std::optional<std::string> closed;
  std::string idle;
  SendReport report;
};

std::string random_text(std::mt19937& random) {
  std::string text;
  const std::size_t length = 1 + random() % 600;
  for (std::size_t i = 0; i < length; ++i) text += static_cast<char>("0123456789XYZGM. -\n"[random() % 19]);
  return text;
}

/// HEADSTOCK_TRANSFERS=500 before a release: some minutes.
unsigned transfers() {
  const char* const wanted = std::getenv("HEADSTOCK_TRANSFERS");
  return wanted == nullptr ? 60 : static_cast<unsigned>(std::strtoul(wanted, nullptr, 10));
}

void many_transfers(SimulatedControl& control, Bench& bench) {
  ASSERT_TRUE(bench.ready()) << bench.closed.value_or("");
  std::mt19937 random(11);
  for (unsigned round = 0; round < transfers(); ++round) {
    const auto text = random_text(random);
    SimulatedControl::Behaviour behaviour;
    behaviour.seed = round;
    bench.send(text);
    control.begin(behaviour, text.size());
    ASSERT_TRUE(bench.finished()) << round << " " << name_of(bench.report.state);
    ASSERT_EQ(bench.report.state, Sender::State::done) << bench.report.reason;
    ASSERT_EQ(control.read_all(), text) << round;
    ASSERT_EQ(bench.report.counters.bytes, text.size());
  }
  EXPECT_GT(control.stops(), transfers() / 2);
  testing::Test::RecordProperty("most_after_stop", static_cast<int>(control.most_after_stop()));
}

TEST(Line, ManyTransfersOverAPseudoTerminal) {
  SimulatedControl control;
  Bench bench(*address_of(control.device()));
  many_transfers(control, bench);
}

TEST(Line, ManyTransfersOverTcp) {
  SimulatedControl control{SimulatedControl::Tcp{}};
  Bench bench(*address_of("tcp://127.0.0.1:" + std::to_string(control.port())));
  many_transfers(control, bench);
}

TEST(Line, AHangUpEndsItByNameAndThePortIsUsableAtOnce) {
  for (unsigned round = 0; round < 20; ++round) {
    SimulatedControl control{SimulatedControl::Tcp{}};
    const auto address = *address_of("tcp://127.0.0.1:" + std::to_string(control.port()));
    Bench bench(address);
    ASSERT_TRUE(bench.ready());
    SimulatedControl::Behaviour behaviour;
    behaviour.hang_up_after = 1 + round * 37;
    bench.send(std::string(2'000'000, 'X'));
    control.begin(behaviour, 2'000'000);
    ASSERT_TRUE(bench.finished());
    EXPECT_EQ(bench.report.state, Sender::State::failed);
    EXPECT_EQ(bench.report.reason, "disconnected");
    ASSERT_TRUE(bench.until([&] { return bench.closed.has_value(); }));
    Bench again(address);
    ASSERT_TRUE(again.ready());
    control.begin({}, 3);
    again.send("ABC");
    control.send("\x11");
    ASSERT_TRUE(again.finished());
    EXPECT_EQ(control.read_all(), "ABC");
  }
}

TEST(Line, APulledTerminalEndsItByName) {
  SimulatedControl control;
  Bench bench(*address_of(control.device()));
  ASSERT_TRUE(bench.ready());
  bench.send(std::string(2'000'000, 'X'));
  SimulatedControl::Behaviour behaviour;
  behaviour.hang_up_after = 500;
  control.begin(behaviour, 2'000'000);
  ASSERT_TRUE(bench.finished());
  EXPECT_EQ(bench.report.reason, "disconnected");
}

TEST(Line, AControlThatDoesNotStartOrDiesStopped) {
  SimulatedControl control;
  auto settings = Bench::fast();
  Bench bench(*address_of(control.device()), settings);
  ASSERT_TRUE(bench.ready());
  auto rules = send_rules(settings);
  rules.start_limit = 50ms;
  bench.line->send(rules, text_source("ABC"), [&](const SendReport& now) { bench.report = now; });
  ASSERT_TRUE(bench.finished());
  EXPECT_EQ(bench.report.reason, "no_start");
  rules.hold_limit = 50ms;
  rules.start_limit = 60s;
  SimulatedControl::Behaviour dies;
  dies.dies_stopped = true;
  bench.report = {};
  constexpr std::size_t kLong = 2'000'000;  // 20 s on the line: not over before a busy computer lets the control stop it
  bench.line->send(rules, text_source(std::string(kLong, 'X')), [&](const SendReport& now) { bench.report = now; });
  control.begin(dies, kLong);
  ASSERT_TRUE(bench.finished());
  EXPECT_EQ(bench.report.reason, "held_too_long");
}

TEST(Line, PauseResumeAndCancel) {
  SimulatedControl control;
  Bench bench(*address_of(control.device()));
  ASSERT_TRUE(bench.ready());
  const std::string text(30'000, 'X');
  bench.send(text);
  SimulatedControl::Behaviour calm;
  calm.stops = false;
  control.begin(calm, text.size());
  ASSERT_TRUE(bench.until([&] { return bench.report.counters.bytes > 0; }));
  bench.line->pause();
  ASSERT_TRUE(bench.until([&] { return bench.report.state == Sender::State::paused; }));
  const auto paused_at = bench.report.counters.bytes;
  bench.io.run_for(300ms);
  bench.io.restart();
  EXPECT_EQ(bench.report.counters.bytes, paused_at);
  bench.line->resume();
  ASSERT_TRUE(bench.finished());
  EXPECT_EQ(control.read_all(), text);
  bench.send(text);
  control.begin(calm, text.size());
  ASSERT_TRUE(bench.until([&] { return bench.report.counters.bytes > 0; }));
  bench.line->cancel();
  EXPECT_EQ(bench.report.state, Sender::State::cancelled);
  EXPECT_FALSE(bench.line->busy());
}

TEST(Line, ReceivesAPunch) {
  SimulatedControl control;
  auto settings = default_settings("xon-xoff");
  Bench bench(*address_of(control.device()), settings);
  ASSERT_TRUE(bench.ready());
  ReceiveReport report;
  std::string text;
  auto rules = receive_rules(settings);
  rules.quiet_after_percent = 20ms;
  bench.line->receive(
      rules,
      [&](std::string_view data) {
        text += data;
        return std::size_t{0};
      },
      [&](const ReceiveReport& now) { report = now; });
  control.send("\x12%\nO1(\xFF)\nM30\n%\n\x14");
  ASSERT_TRUE(bench.until([&] { return report.over(); }));
  EXPECT_EQ(report.state, Receiver::State::done);
  EXPECT_TRUE(report.closed);
  EXPECT_EQ(text, "%\nO1(\xFF)\nM30\n%\n") << "a byte FF comes through a terminal that marks errors";
}

TEST(Line, IdleBytesAreHandedOver) {
  SimulatedControl control;
  Bench bench(*address_of(control.device()), default_settings("xon-xoff"));
  ASSERT_TRUE(bench.ready());
  control.send("%\nO9(GET=1234)\n%\n");
  EXPECT_TRUE(bench.until([&] { return bench.idle == "%\nO9(GET=1234)\n%\n"; }));
  const auto seen = bench.line->monitor().since(0, 100);
  ASSERT_GE(seen.size(), 2u);
  EXPECT_EQ(seen.back().kind, MonitorEntry::in);
}

TEST(Line, LoopBackTest) {
  SimulatedControl control;
  auto settings = default_settings("xon-xoff");
  settings.line.baud = 115'200;
  Bench bench(*address_of(control.device()), settings);
  ASSERT_TRUE(bench.ready());
  std::optional<LoopReport> report;
  control.echo();
  bench.line->loop_test(1'000, [&](const LoopReport& now) { report = now; });
  ASSERT_TRUE(bench.until([&] { return report.has_value(); }));
  EXPECT_TRUE(report->ok) << report->reason << " " << report->first_wrong;
  EXPECT_EQ(report->received, 1'000u);
  EXPECT_GT(report->characters_s, 1'000);
}

TEST(Line, LoopBackWithoutAPlug) {
  SimulatedControl control;
  Bench bench(*address_of(control.device()), default_settings("xon-xoff"));
  ASSERT_TRUE(bench.ready());
  std::optional<LoopReport> report;
  bench.line->loop_test(50, [&](const LoopReport& now) { report = now; });
  ASSERT_TRUE(bench.until([&] { return report.has_value(); }));
  EXPECT_FALSE(report->ok);
  EXPECT_EQ(report->reason, "nothing_came");
}

std::string why_closed(const std::string& address, const LineSettings& settings = {}) {
  auto link = default_settings("xon-xoff");
  link.line = settings;
  Bench bench(*address_of(address), link);
  EXPECT_FALSE(bench.ready());
  return bench.closed.value_or("");
}

TEST(Line, APortThatCannotBeOpenedSaysWhy) {
  EXPECT_EQ(why_closed("/dev/headstock-no-such-port"), "port_not_found");
  EXPECT_EQ(why_closed("/dev/null"), "not_a_serial_port");
  EXPECT_EQ(why_closed("tcp://127.0.0.1:1"), "connect_failed");
  SimulatedControl control;
  Bench first(*address_of(control.device()), default_settings("xon-xoff"));
  ASSERT_TRUE(first.ready());
  EXPECT_EQ(why_closed(control.device()), "port_in_use");
}

TEST(Line, EverySpeedIsSet) {
  SimulatedControl control;
  for (const std::uint32_t baud :
       {50u,     75u,     110u,     134u,     150u,     200u,     300u,     600u,    1'200u,
        1'800u,  2'400u,  4'800u,   9'600u,   14'400u,  19'200u,  28'800u,  31'250u, 38'400u,
        57'600u, 76'800u, 115'200u, 230'400u, 460'800u, 500'000u, 576'000u, 921'600u}) {
    auto settings = default_settings("xon-xoff");
    settings.line.baud = baud;
    Bench bench(*address_of(control.device()), settings);
    EXPECT_TRUE(bench.ready()) << baud << " " << bench.closed.value_or("");
  }
}

TEST(Address, ReadsWhatIsAPortAndNothingElse) {
  for (const char* text :
       {"/dev/ttyS0", "tcp://serial-1:4001", "rfc2217://[fe80::1]:7000", "tcp://10.0.0.7:65535"}) {
    ASSERT_TRUE(address_of(text)) << text;
    EXPECT_EQ(to_text(*address_of(text)), text);
  }
  for (const char* text :
       {"", "ttyS0", "/dev/../etc/passwd", "tcp://", "tcp://host", "tcp://:1", "tcp://h:0", "tcp://h:65536",
        "tcp://a b:1", "tcp://u@h:1", "tcp://fe80::1:1", "http://h:1", "tcp://h:1/x"})
    EXPECT_FALSE(address_of(text)) << text;
}

}  // namespace
}  // namespace headstock::serial
