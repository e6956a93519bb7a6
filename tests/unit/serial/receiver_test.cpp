#include "protocol/serial/receiver.hpp"

#include <gtest/gtest.h>

#include "protocol/serial/protocols.hpp"

namespace headstock::serial {
namespace {

using namespace std::chrono_literals;
using State = Receiver::State;

Time at(Duration time) {
  return Time(1h + time);
}

TEST(Receiver, BetweenDc2AndDc4) {
  auto settings = default_settings("dc1-dc4");
  settings.code = tape::Code::ascii;
  Receiver receiver(receive_rules(settings), at(0s));
  std::string data;
  receiver.on_bytes("\x12%\nO1\n", at(1s), data);
  EXPECT_EQ(receiver.state(), State::receiving);
  receiver.on_bytes("M30\n%\n\x14GHOST", at(2s), data);
  EXPECT_EQ(receiver.state(), State::done);
  EXPECT_TRUE(receiver.closed());
  EXPECT_EQ(data, "%\nO1\nM30\n%\n");
}

TEST(Receiver, ChineseInAsciiIsNotASteeringCode) {
  auto settings = default_settings("xon-xoff");
  Receiver receiver(receive_rules(settings), at(0s));
  std::string data;
  receiver.on_bytes("(\x93\xE1\x91\x94)\n", at(1s), data);
  EXPECT_EQ(data, "(\x93\xE1\x91\x94)\n");
}

TEST(Receiver, EndsByPercentByQuietOrByEndByte) {
  auto settings = default_settings("xon-xoff");
  std::string data;
  Receiver percent(receive_rules(settings), at(0s));
  percent.on_bytes("%\nO1\n%\n", at(1s), data);
  percent.tick(at(1s + 400ms));
  EXPECT_FALSE(percent.over());
  percent.tick(at(1s + 500ms));
  EXPECT_EQ(percent.state(), State::done);
  EXPECT_TRUE(percent.closed());
  Receiver quiet(receive_rules(settings), at(0s));
  quiet.on_bytes("%\nO1\nG0", at(1s), data);
  quiet.tick(at(5s));
  EXPECT_FALSE(quiet.over());
  quiet.tick(at(6s));
  EXPECT_EQ(quiet.state(), State::done);
  EXPECT_FALSE(quiet.closed()) << "it only fell silent";
  data.clear();
  Receiver lathe(receive_rules(default_settings("lathe-200t")), at(0s));
  lathe.on_bytes("G0\r\n\x1A", at(1s), data);
  EXPECT_EQ(lathe.state(), State::done);
  EXPECT_TRUE(lathe.closed());
  EXPECT_EQ(data, "G0\r\n");
}

TEST(Receiver, FaultsTooMuchAndNothing) {
  auto rules = receive_rules(default_settings("xon-xoff"));
  rules.most_bytes = 100;
  std::string data;
  Receiver noisy(rules, at(0s));
  noisy.on_fault(Fault::framing, at(0s));  // the control is switched on
  noisy.on_bytes("%\nO1", at(1s), data);
  noisy.on_fault(Fault::parity, at(1s));
  noisy.on_bytes("\n%\n", at(1s), data);
  noisy.tick(at(2s));
  EXPECT_EQ(noisy.state(), State::failed);
  EXPECT_EQ(noisy.reason(), "line_parity");
  Receiver endless(rules, at(0s));
  endless.on_bytes(std::string(200, 'X'), at(1s), data);
  EXPECT_EQ(endless.reason(), "too_large");
  Receiver silent(rules, at(0s));
  silent.on_bytes(std::string(50, '\0'), at(1s), data);  // leader only
  silent.tick(at(10min));
  EXPECT_EQ(silent.reason(), "nothing_came");
  Receiver cut(rules, at(0s));
  cut.on_bytes("%\nO1", at(1s), data);
  cut.on_fault(Fault::disconnected, at(1s));
  EXPECT_EQ(cut.reason(), "disconnected");
}

TEST(Receiver, StopsTheOtherSideWhenBytesPileUpAndNeverLeavesItStopped) {
  auto rules = receive_rules(default_settings("xon-xoff"));
  Receiver receiver(rules, at(0s));
  receiver.on_backlog(rules.backlog_high);
  EXPECT_EQ(receiver.take_output(), "\x13");
  receiver.on_backlog(rules.backlog_low + 1);
  EXPECT_EQ(receiver.take_output(), "");
  receiver.on_backlog(rules.backlog_low);
  EXPECT_EQ(receiver.take_output(), "\x11");
  receiver.on_backlog(rules.backlog_high);
  receiver.take_output();
  receiver.cancel(at(1s));
  EXPECT_EQ(receiver.take_output(), "\x11");
}

TEST(Receiver, AsksWhenTold) {
  ReceiveRules rules;
  rules.ask = true;
  EXPECT_EQ(Receiver(rules, at(0s)).take_output(), "\x11");
}

TEST(Receiver, TwoGigabytesAreRefusedAndNotKept) {
  auto settings = default_settings("xon-xoff");
  Receiver receiver(receive_rules(settings), at(0s));
  const std::string piece(1u << 20, 'X');
  std::string data;
  std::size_t most = 0;
  for (unsigned i = 0; i < 2'048; ++i) {
    receiver.on_bytes(piece, at(1s + i * 1ms), data);
    most = std::max(most, data.size());
  }
  EXPECT_EQ(receiver.state(), State::failed);
  EXPECT_EQ(receiver.reason(), "too_large");
  EXPECT_LE(most, settings.most_bytes + piece.size());
}

TEST(Receiver, APunchThatNeverEnds) {
  auto settings = default_settings("xon-xoff");
  settings.punch_limit_s = 60;
  Receiver receiver(receive_rules(settings), at(0s));
  std::string data;
  for (unsigned second = 1; !receiver.over() && second < 1'000; ++second) {
    receiver.on_bytes("X1\n", at(second * 1s), data);
    receiver.tick(at(second * 1s));
  }
  EXPECT_EQ(receiver.state(), State::failed);
  EXPECT_EQ(receiver.reason(), "never_ends");
  EXPECT_LE(data.size(), 3u * 62);
}

}  // namespace
}  // namespace headstock::serial
