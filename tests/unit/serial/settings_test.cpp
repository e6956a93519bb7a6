#include "protocol/serial/settings.hpp"

#include <gtest/gtest.h>

#include "protocol/serial/monitor.hpp"
#include "protocol/serial/protocols.hpp"

namespace headstock::serial {
namespace {

TEST(Settings, TextBothWays) {
  for (const char* text : {"9600-8-N-1-software", "50-7-E-2-none", "921600-8-O-1-hardware",
                           "31250-8-M-1-both", "4800-5-S-2-none"}) {
    const auto settings = settings_of(text);
    ASSERT_TRUE(settings) << text;
    EXPECT_EQ(to_text(*settings), text);
  }
  EXPECT_EQ(settings_of("9600-8-N-1")->handshake, Handshake::software);
}

TEST(Settings, WhatIsOutOfRangeIsRefused) {
  for (const char* text :
       {"", "9600", "49-8-N-1", "921601-8-N-1", "9600-4-N-1", "9600-9-N-1", "9600-8-X-1", "9600-8-N-3",
        "9600-8-N-1-xon", "9600-5-N-1-software", "9600-8-N-1-", "-1-8-N-1", "264-264-N-1"})
    EXPECT_FALSE(settings_of(text)) << text;
}

TEST(Settings, CharactersASecond) {
  EXPECT_DOUBLE_EQ(settings_of("9600-8-N-1")->characters_s(), 960);
  EXPECT_DOUBLE_EQ(settings_of("9600-8-O-1")->bits_a_character(), 11);
  EXPECT_DOUBLE_EQ(settings_of("4800-7-E-2")->bits_a_character(), 11);
}

TEST(Protocols, EveryRowIsWholeAndUsable) {
  for (const Protocol& row : protocols()) {
    SCOPED_TRACE(std::string(row.name));
    EXPECT_FALSE(row.en.empty());
    EXPECT_FALSE(row.zh.empty());
    const auto settings = default_settings(row.name);
    EXPECT_EQ(wrong_field(settings.line), "");
    EXPECT_LT(send_rules(settings).window, row.after_stop)
        << "more under way than the control takes after DC3";
  }
  EXPECT_EQ(protocol_named("none"), nullptr);
  EXPECT_THROW(default_settings("none"), std::invalid_argument);
}

TEST(Protocols, TheManualsLines) {
  const auto lathe = default_settings("lathe-200t");  // 200T L5610
  EXPECT_EQ(to_text(lathe.line), "9600-8-O-1-software");
  EXPECT_EQ(send_rules(lathe).ending, "\x1A");
  EXPECT_EQ(receive_rules(lathe).end_byte, 0x1A);
  const auto fanuc = default_settings("dc1-dc4");
  EXPECT_EQ(fanuc.after_stop, 10u);  // PS0087
  EXPECT_TRUE(send_rules(fanuc).wait_for_start);
  EXPECT_EQ(receive_rules(fanuc).percent, 0xA5);
  EXPECT_EQ(default_settings("gsk-2000tc").line.baud, 115'200u);  // P044
}

TEST(Monitor, NamesControlCharacters) {
  EXPECT_EQ(readable("\x11G0\x0D\x0A", false), "<DC1>G0<CR><LF>");
  EXPECT_EQ(readable("\x93\xC3\xA0", true), "<DC3>C ");
  EXPECT_EQ(readable("\xFF", false), "<FF>");
  EXPECT_EQ(hexadecimal("\x11\xA0"), "11 A0");
}

TEST(Monitor, JoinsNeighboursAndStaysBounded) {
  Monitor monitor(4'096);
  monitor.bytes(MonitorEntry::in, "AB", 1'000);
  monitor.bytes(MonitorEntry::in, "C", 1'050);
  monitor.bytes(MonitorEntry::out, "D", 1'060);
  monitor.add(MonitorEntry::fault, "line_parity", 1'070);
  monitor.bytes(MonitorEntry::out, "E", 1'080);
  const auto seen = monitor.since(0, 100);
  ASSERT_EQ(seen.size(), 4u);
  EXPECT_EQ(seen[0].data, "ABC");
  EXPECT_EQ(seen[2].data, "line_parity");
  for (int i = 0; i < 100'000; ++i) monitor.bytes(MonitorEntry::in, "0123456789", i);
  std::size_t bytes = 0;
  for (const auto& entry : monitor.since(0, 100'000)) bytes += entry.data.size();
  EXPECT_LE(bytes, 4'096u);
  EXPECT_EQ(monitor.since(monitor.last() - 1, 10).size(), 1u);
}

TEST(Pacing, FollowsFromWhatThePortHasMeasured) {
  using namespace std::chrono_literals;
  auto settings = default_settings("dc1-dc4");  // 9600-8-N-2: 1.146 ms a character, takes 10 after its DC3
  EXPECT_EQ(window_of(settings), 8u);
  EXPECT_EQ(window_of(settings, 1'200us), 7u) << "a plain UART";
  EXPECT_EQ(window_of(settings, 5'000us), 4u) << "an adapter that holds characters back for 4 ms";
  EXPECT_EQ(stop_margin(settings, 5'000us), 2);
  EXPECT_EQ(window_of(settings, 20'000us), 1u) << "16 ms: this line cannot be stopped in time";
  EXPECT_LT(stop_margin(settings, 20'000us), 0);
  settings.after_stop = 100;
  EXPECT_GT(stop_margin(settings, 20'000us), 0);
  EXPECT_EQ(send_rules(settings, 20'000us).window, window_of(settings, 20'000us));
}

}  // namespace
}  // namespace headstock::serial
