// What terminals and serial-device servers put around the data.
#include <gtest/gtest.h>

#include "protocol/serial/port/mark_decoder.hpp"
#include "protocol/serial/port/rfc2217.hpp"

namespace headstock::serial {
namespace {

using namespace std::string_literals;

TEST(MarkDecoder, FindsErrorsAndKeepsBytes) {
  MarkDecoder decoder;
  std::string data;
  const auto faults = decoder.put(
      "A\xFF\xFF"
      "B\xFF\0C\xFF\0\0D"s,
      data);
  EXPECT_EQ(data,
            "A\xFF"
            "BD");
  EXPECT_EQ(faults, (std::vector{Fault::parity, Fault::line_break}));
}

TEST(MarkDecoder, CutAnywhere) {
  MarkDecoder decoder;
  std::string data;
  std::vector<Fault> faults;
  for (const char c :
       "A\xFF\xFF"
       "B\xFF\0C\xFF\0\0D"s)
    for (const Fault fault : decoder.put({&c, 1}, data)) faults.push_back(fault);
  EXPECT_EQ(data,
            "A\xFF"
            "BD");
  EXPECT_EQ(faults.size(), 2u);
}

std::string sub(const std::string& body) {
  std::string text("\xFF\xFA\x2C");
  text += body;
  return text += "\xFF\xF0";
}

TEST(Rfc2217, AsksForTheLineAndIsReadyWhenAllIsConfirmed) {
  Rfc2217 telnet(*settings_of("9600-7-E-2"));
  EXPECT_NE(telnet.hello().find("\xFF\xFB\x2C"), std::string::npos);
  std::string answer;
  telnet.put("\xFF\xFD\x2C"s, answer);
  EXPECT_NE(answer.find(sub("\x01\0\0\x25\x80"s)), std::string::npos);
  EXPECT_NE(answer.find(sub("\x02\x07")), std::string::npos);
  EXPECT_NE(answer.find(sub("\x03\x03")), std::string::npos);
  EXPECT_NE(answer.find(sub("\x04\x02")), std::string::npos);
  auto events = telnet.put(sub("\x65\0\0\x25\x80"s) + sub("\x66\x07") + sub("\x67\x03"), answer);
  EXPECT_FALSE(telnet.ready());
  events = telnet.put(sub("\x68\x02") + "HI\xFF\xFF", answer);
  EXPECT_TRUE(events.ready);
  EXPECT_EQ(events.data, "HI\xFF");
}

TEST(Rfc2217, ASettingTheServerDoesNotTakeIsNamed) {
  Rfc2217 telnet(*settings_of("9600-8-M-1"));
  std::string answer;
  EXPECT_EQ(telnet.put(sub("\x67\x01"), answer).refused, "bad_parity");
  EXPECT_EQ(telnet.put(sub("\x65\0\0\x12\xC0"s), answer).refused, "bad_baud");
  EXPECT_EQ(telnet.put("\xFF\xFE\x2C"s, answer).refused, "no_rfc2217");
}

TEST(Rfc2217, ReportsErrorsAndSignals) {
  Rfc2217 telnet(*settings_of("9600-8-N-1"));
  std::string answer;
  const auto events = telnet.put(sub("\x6A\x1E") + sub("\x6B\x30"), answer);
  EXPECT_EQ(events.faults, (std::vector{Fault::overrun, Fault::parity, Fault::framing, Fault::line_break}));
  EXPECT_TRUE(events.signals_changed);
  EXPECT_TRUE(telnet.signals().cts);
  EXPECT_TRUE(telnet.signals().dsr);
  EXPECT_FALSE(telnet.signals().dcd);
}

TEST(Rfc2217, EscapesDataAndSurvivesAnyCut) {
  EXPECT_EQ(Rfc2217::escaped("A\xFF"
                             "B"),
            "A\xFF\xFF"
            "B");
  Rfc2217 telnet(*settings_of("9600-8-N-1"));
  std::string answer, data;
  std::string stream(1, 'X');
  stream += sub("\x6B\xFF\xFF");
  stream += "Y\xFF\xFFZ\xFF\xF1W";
  for (const char c : stream) data += telnet.put({&c, 1}, answer).data;
  EXPECT_EQ(data,
            "XY\xFF"
            "ZW");
  EXPECT_TRUE(telnet.signals().dcd);
}

TEST(Rfc2217, UnknownOptionsAreRefused) {
  Rfc2217 telnet(*settings_of("9600-8-N-1"));
  std::string answer;
  telnet.put("\xFF\xFB\x01\xFF\xFD\x18"s, answer);  // WILL ECHO, DO TERMINAL-TYPE
  EXPECT_EQ(answer, "\xFF\xFE\x01\xFF\xFC\x18");
}

}  // namespace
}  // namespace headstock::serial
