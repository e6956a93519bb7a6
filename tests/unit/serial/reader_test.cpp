// A control fed by somebody else's DNC software.
#include "protocol/serial/reader.hpp"

#include <gtest/gtest.h>

#include <random>

#include "protocol/serial/protocols.hpp"
#include "protocol/serial/sender.hpp"

namespace headstock::serial {
namespace {

using State = Reader::State;

std::string taken(Reader& reader, std::size_t at_most = 100'000) {
  std::string text(at_most, '\0');
  text.resize(reader.take(text));
  return text;
}

TEST(Reader, SkipsTheLabelAndStopsAtThePercent) {
  Reader reader({});
  reader.start();
  EXPECT_EQ(reader.take_output(), "\x11");
  reader.on_bytes(std::string("\0\0TITLE%\n", 9));
  reader.on_bytes("O1\nG0X1\nM30\n%\nMORE");
  EXPECT_EQ(reader.state(), State::ended);
  EXPECT_EQ(reader.take_output(), "\x13");
  EXPECT_EQ(taken(reader), "O1\nG0X1\nM30\n%\n");
}

TEST(Reader, StopsBeforeItsBufferIsFullAndGoesOn) {
  ReaderRules rules;
  rules.buffer = 64;
  Reader reader(rules);
  reader.start();
  reader.take_output();
  reader.on_bytes("%\n" + std::string(53, 'A'));
  EXPECT_EQ(reader.take_output(), "");
  reader.on_bytes("A");
  EXPECT_EQ(reader.take_output(), "\x13");
  reader.on_bytes(std::string(10, 'B'));  // what a sender may still have under way
  EXPECT_EQ(reader.state(), State::reading);
  taken(reader, 31);
  EXPECT_EQ(reader.take_output(), "");
  taken(reader, 1);
  EXPECT_EQ(reader.take_output(), "\x11");
  EXPECT_EQ(reader.most_after_stop(), 10u);
}

TEST(Reader, MoreThanTenAfterDc3IsTheOverflowAlarm) {
  ReaderRules rules;
  rules.buffer = 64;
  Reader reader(rules);
  reader.start();
  reader.on_bytes("%\n" + std::string(54, 'A') + std::string(11, 'B'));
  EXPECT_EQ(reader.state(), State::failed);
  EXPECT_EQ(reader.reason(), "buffer_overflow");
}

TEST(Reader, ChecksParityAndBlocks) {
  ReaderRules rules;
  rules.code = tape::Code::iso;
  Reader parity(rules);
  parity.start();
  parity.on_bytes(
      "\xA5\x0A"
      "G");
  parity.on_bytes("\xC7");  // G with a wrong bit 8
  EXPECT_EQ(parity.reason(), "th");
  rules.code = tape::Code::ascii;
  rules.tv_check = true;
  Reader block(rules);
  block.start();
  block.on_bytes("%\nG01\n");
  EXPECT_EQ(block.state(), State::reading);
  block.on_bytes("G1\n");
  EXPECT_EQ(block.reason(), "tv");
}

TEST(Reader, DrOff) {
  Reader reader({});
  reader.start();
  reader.on_signals({.dsr = true, .known = true});
  reader.on_signals({.dsr = false, .known = true});
  EXPECT_EQ(reader.reason(), "dr_off");
}

TEST(Reader, IsoStopsWithParity) {
  ReaderRules rules;
  rules.code = tape::Code::iso;
  rules.buffer = 64;
  Reader reader(rules);
  reader.start();
  EXPECT_EQ(reader.take_output(), "\x11");
  reader.on_bytes("\xA5\x0A" + std::string(54, 'A'));
  EXPECT_EQ(reader.take_output(), "\x93");
}

TEST(Reader, OurSenderNeverOverflowsOurReader) {
  std::mt19937 random(3);
  for (unsigned round = 0; round < 200; ++round) {
    std::string text = "%\n";
    for (unsigned line = 0; line < 1 + random() % 100; ++line)
      text += "G1X" + std::to_string(random() % 100'000) + "\n";
    text += "%\n";
    ReaderRules rules;
    rules.buffer = 128;
    Reader reader(rules);
    Time now{std::chrono::hours(1)};
    auto sending = send_rules(default_settings("dc1-dc4"));
    Sender sender(sending, text_source(text), now);
    reader.start();
    std::string program;
    for (int step = 0; step < 1'000'000 && reader.state() == State::reading; ++step) {
      now += sending.character;
      sender.on_bytes(reader.take_output(), now);
      const auto bytes = std::string(sender.peek(now, 0));
      sender.wrote(bytes.size(), now);
      reader.on_bytes(bytes);
      if (random() % 3 == 0) program += taken(reader, random() % 20);
    }
    EXPECT_EQ(reader.state(), State::ended) << reader.reason();
    program += taken(reader);
    EXPECT_EQ("%\n" + program, text);
  }
}

}  // namespace
}  // namespace headstock::serial
