// The machine as the receiving end: what is said on the line, what the interpreter gets, and when it is over.
#include "agent/dnc_input.hpp"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>

#include "protocol/wire/digest.hpp"

namespace headstock::agent {
namespace {

using program::ReadStatus;
using State = DncInput::State;
constexpr char kDc1 = '\x11', kDc3 = '\x13';

/// A line whose other end is the test.
struct Wire {
  serial::PortListener* listener = nullptr;
  std::string written;
  int opened = 0, closed = 0;
};
class WirePort final : public serial::Port {
 public:
  explicit WirePort(Wire& wire) : wire_(wire) {}
  void open(serial::PortListener& listener) override {
    ++wire_.opened;
    wire_.listener = &listener;
  }
  std::size_t write(std::string_view bytes) override {
    wire_.written += bytes;
    return bytes.size();
  }
  std::size_t queued() const override { return 0; }
  void hold_output(bool) override {}
  void discard_output() override {}
  void set_rts(bool) override {}
  serial::Signals signals() override { return {}; }
  void close() override { ++wire_.closed; }

 private:
  Wire& wire_;
};

struct Dnc : ::testing::Test {
  boost::asio::io_context io;
  Wire wire;
  operation::CommandResult answer{true, ""};
  int offers = 0;
  std::unique_ptr<program::Source> stream;
  std::function<std::string()> why;
  std::unique_ptr<DncInput> input;

  void make(DncSettings settings = ascii()) {
    input = std::make_unique<DncInput>(
        io.get_executor(), settings,
        [this](std::unique_ptr<program::Source> offered, std::function<std::string()> asked) {
          ++offers;
          if (answer.accepted) {
            stream = std::move(offered);
            why = std::move(asked);
          }
          return answer;
        },
        [this] { return std::make_unique<WirePort>(wire); });
  }
  static DncSettings ascii() {
    DncSettings settings;
    settings.port = "test";
    settings.code = tape::Code::ascii;
    return settings;
  }
  void on() {
    ASSERT_TRUE(input->switch_on().accepted);
    wire.listener->on_open();
    settle();
  }
  void settle() {
    io.restart();
    io.poll();
  }
  void settle_for(std::chrono::milliseconds time) {
    io.restart();
    io.run_for(time);
  }
  /// Until nothing is left to do, timers included.
  void settle_all() {
    io.restart();
    io.run();
  }
  void came(std::string_view bytes) {
    wire.listener->on_bytes(bytes);
    settle();
  }
  ReadStatus read(std::string& into, std::size_t at_most = 1000) {
    std::string buffer(at_most, '\0');
    const auto result = stream->read({buffer.data(), buffer.size()});
    into.append(buffer, 0, result.bytes);
    settle();
    return result.status;
  }
  State state() { return input->status().state; }
};

TEST_F(Dnc, AsksWhenCycleStartReadsAndNotBefore) {
  make();
  on();
  EXPECT_EQ(state(), State::ready);
  EXPECT_EQ(wire.written, "");
  std::string text;
  EXPECT_EQ(read(text), ReadStatus::wait);
  EXPECT_EQ(wire.written, std::string(1, kDc1));
  EXPECT_EQ(state(), State::reading);
  came("%\nO1\nG00 X1.\n");
  EXPECT_EQ(read(text), ReadStatus::data);
  EXPECT_EQ(text, "O1\nG00 X1.\n");
  EXPECT_EQ(read(text), ReadStatus::wait);
}

TEST_F(Dnc, AsksAgainWhileNothingComes) {
  make();
  on();
  std::string text;
  read(text);
  while (wire.written.size() < 3) settle_for(std::chrono::milliseconds(100));
  EXPECT_EQ(wire.written, std::string(3, kDc1)) << "the sender may have opened its side only now";
  came("%\nO1\n");
  settle_for(std::chrono::milliseconds(1'200));
  EXPECT_EQ(wire.written.size(), 3u);
}

TEST_F(Dnc, AProgramToItsPercentIsDrainedAndTheNextOneIsOffered) {
  make();
  on();
  std::string text;
  read(text);
  came("%\nO1\nG00 X1.\nM30\n%\n");
  EXPECT_EQ(read(text), ReadStatus::data);
  EXPECT_EQ(read(text), ReadStatus::end);
  stream.reset();
  settle_all();
  const auto status = input->status();
  EXPECT_EQ(status.state, State::ready);
  EXPECT_EQ(status.outcome, "drained");
  EXPECT_EQ(status.bytes, text.size());
  EXPECT_EQ(status.sha256, wire::sha256_hex(text));
  EXPECT_EQ(offers, 2);
  EXPECT_EQ(wire.opened, 1);
  wire.written.clear();
  std::string next;
  EXPECT_EQ(read(next), ReadStatus::wait);
  EXPECT_EQ(wire.written, std::string(1, kDc1)) << "nothing was asked for before cycle start";
  came("%\nO2\nM30\n%\n");
  read(next);
  EXPECT_EQ(next, "O2\nM30\n%\n");
}

TEST_F(Dnc, ThePercentBehindM30BelongsToTheProgramThatIsOver) {
  make();
  on();
  std::string text;
  read(text);
  came("%\nO1\nM30\n");
  read(text);
  stream.reset();  // M30: the interpreter has no need of more
  settle();
  EXPECT_EQ(state(), State::finishing);
  came("%\n");
  settle_all();
  EXPECT_EQ(state(), State::ready);
  EXPECT_EQ(input->status().outcome, "drained");
}

TEST_F(Dnc, ResetInTheMiddleStopsTheSenderAndSwitchesOff) {
  make();
  on();
  std::string text;
  read(text);
  came("%\nO1\nG01 X1. F100.\n");
  read(text);
  stream.reset();
  settle();
  came("X2.\nX3.\n");
  EXPECT_EQ(state(), State::off) << "the rest of a program is not run by the next cycle start";
  EXPECT_EQ(input->status().reason, "broken_off");
  EXPECT_EQ(wire.written.back(), kDc3);
  EXPECT_EQ(wire.closed, 1);
  settle_all();
  EXPECT_EQ(offers, 1);
}

TEST_F(Dnc, WhatCameBeforeAFaultIsGoodAndThenItFailsByName) {
  make();
  on();
  std::string text;
  read(text);
  came("%\nG01 X1. F100.\nX2.\nX");
  wire.listener->on_fault(serial::Fault::parity);
  settle();
  EXPECT_EQ(wire.written.back(), kDc3);
  EXPECT_EQ(read(text), ReadStatus::data);
  EXPECT_EQ(text, "G01 X1. F100.\nX2.\nX");
  EXPECT_EQ(read(text), ReadStatus::failed);
  EXPECT_EQ(why(), "line_parity");
  stream.reset();
  settle_all();
  EXPECT_EQ(state(), State::off);
  EXPECT_EQ(input->status().outcome, "line_parity");
}

TEST_F(Dnc, TheRestOfAProgramIsNotAProgram) {
  make();
  on();
  std::string text;
  read(text);
  came("X2. Y3.\nX4.\n");
  EXPECT_EQ(read(text), ReadStatus::failed);
  EXPECT_EQ(text, "");
  EXPECT_EQ(why(), "no_start_mark");
}

TEST_F(Dnc, WhoeverWantsItMaySendWithoutThePercent) {
  DncSettings settings = ascii();
  settings.any_start = true;
  make(settings);
  on();
  std::string text;
  read(text);
  came("TITLE\nX4.\n");
  EXPECT_EQ(read(text), ReadStatus::data);
  EXPECT_EQ(text, "X4.\n");
}

TEST_F(Dnc, MoreThanItTakesAfterItsStopIsTheOverflowAlarm) {
  DncSettings settings = ascii();
  settings.buffer = 1024;
  settings.after_stop = 10;
  make(settings);
  on();
  std::string text;
  read(text);
  came("%\n" + std::string(1014, 'X'));
  EXPECT_EQ(wire.written.back(), kDc3);
  came(std::string(10, 'X'));
  EXPECT_EQ(why(), "disconnected") << "nothing is wrong yet";
  came("X");
  while (read(text) == ReadStatus::data) {
  }
  EXPECT_EQ(why(), "buffer_overflow");
  EXPECT_EQ(text.size(), 1024u) << "what had room is there";
}

TEST_F(Dnc, StopsWhileTheMachineHoldsAndGoesOn) {
  DncSettings settings = ascii();
  settings.buffer = 1024;
  settings.after_stop = 64;
  make(settings);
  on();
  std::string text, sent = "%\n";
  read(text);
  came(sent);
  bool stopped = false;
  std::string program;
  for (int i = 0; program.size() < 20'000; ++i)
    program += "N" + std::to_string(i) + " X" + std::to_string(i) + ".\n";
  program += "%\n";
  std::size_t at = 0;
  int stops = 0;
  while (text.size() < program.size()) {
    for (int i = 0; i < 100 && !stopped && at < program.size(); ++i) {
      came(program.substr(at++, 1));
      for (const char c : wire.written) stopped = c == kDc3 || (stopped && c != kDc1);
      stops += stopped;
      wire.written.clear();
    }
    ASSERT_NE(read(text, 37), ReadStatus::failed) << why();
    for (const char c : wire.written) stopped = c == kDc3 || (stopped && c != kDc1);
    wire.written.clear();
  }
  EXPECT_EQ(text, program);
  EXPECT_GT(stops, 5);
}

TEST_F(Dnc, APortThatCannotBeOpenedFailsAtCycleStart) {
  make();
  ASSERT_TRUE(input->switch_on().accepted);
  wire.listener->on_closed("port_not_found", "No such file or directory");
  EXPECT_EQ(input->status().reason, "port_not_found");
  std::string text;
  EXPECT_EQ(read(text), ReadStatus::failed);
  EXPECT_EQ(why(), "disconnected");
}

TEST_F(Dnc, ALostPortInTheMiddleFails) {
  make();
  on();
  std::string text;
  read(text);
  came("%\nX1.\n");
  wire.listener->on_closed("disconnected", "unplugged");
  EXPECT_EQ(read(text), ReadStatus::data);
  EXPECT_EQ(read(text), ReadStatus::failed);
  EXPECT_EQ(why(), "disconnected");
}

TEST_F(Dnc, SwitchedOffWhileItRunsIsAFault) {
  make();
  on();
  std::string text;
  read(text);
  EXPECT_EQ(input->switch_on().reason, "running");
  input->switch_off();
  EXPECT_EQ(wire.written.back(), kDc3);
  EXPECT_EQ(read(text), ReadStatus::failed);
}

TEST_F(Dnc, ARefusalOfTheControllerIsTold) {
  make();
  answer = {false, "running"};
  EXPECT_EQ(input->switch_on().reason, "running");
  settle_all();
  EXPECT_EQ(state(), State::off);
  EXPECT_EQ(wire.opened, 0);
}

TEST_F(Dnc, AnotherProgramChosenEndsIt) {
  make();
  on();
  stream.reset();  // what the controller does with it then
  settle_all();
  EXPECT_EQ(state(), State::off);
  EXPECT_EQ(wire.closed, 1);
}

TEST_F(Dnc, AStreamThatOutlivesTheInputIsHarmless) {
  make();
  on();
  input.reset();
  settle_all();
  std::string text;
  EXPECT_EQ(read(text), ReadStatus::failed);
  stream.reset();
  settle_all();
}

}  // namespace
}  // namespace headstock::agent
