// What may be said behind --dnc.
#include "agent/dnc_settings.hpp"

#include <gtest/gtest.h>

namespace headstock::agent {
namespace {

TEST(DncSettings, ReadsPortLineAndCode) {
  DncSettings settings;
  EXPECT_EQ(
      read_dnc_settings("/dev/ttyS0,line=4800-7-E-2-software,code=ascii,after-stop=10,buffer=2048,tv-check",
                        settings),
      "");
  EXPECT_EQ(settings.port, "/dev/ttyS0");
  ASSERT_TRUE(settings.address);
  EXPECT_EQ(settings.address->device, "/dev/ttyS0");
  EXPECT_EQ(settings.line.baud, 4800u);
  EXPECT_EQ(settings.code, tape::Code::ascii);
  EXPECT_EQ(settings.after_stop, 10u);
  EXPECT_EQ(settings.buffer, 2048u);
  EXPECT_TRUE(settings.tv_check);
  EXPECT_FALSE(settings.any_start);

  EXPECT_EQ(read_dnc_settings("listen://127.0.0.1:4001,any-start", settings), "");
  EXPECT_FALSE(settings.address);
  EXPECT_EQ(settings.listen_address, "127.0.0.1");
  EXPECT_EQ(settings.listen_port, 4001);
  EXPECT_TRUE(settings.any_start);
  EXPECT_EQ(settings.code, tape::Code::iso);
}

TEST(DncSettings, SaysWhatItDoesNotUnderstandAndChangesNothing) {
  for (const char* bad : {"", "ttyS0", "/dev/../etc/passwd", "listen://:4001", "listen://127.0.0.1:70000",
                          "/dev/ttyS0,line=9600", "/dev/ttyS0,code=ebcdic", "/dev/ttyS0,buffer=1",
                          "/dev/ttyS0,after-stop=9", "/dev/ttyS0,speed=9600", "/dev/ttyS0,"}) {
    DncSettings settings;
    EXPECT_NE(read_dnc_settings(bad, settings), "") << bad;
    EXPECT_EQ(settings.port, "") << bad;
  }
}

TEST(DncSettings, TheBufferHasRoomForWhatComesAfterAStop) {
  DncSettings settings;
  EXPECT_EQ(read_dnc_settings("/dev/ttyS0,buffer=1024,after-stop=4096", settings), "");
  EXPECT_GT(settings.buffer, 2 * settings.after_stop);
}

}  // namespace
}  // namespace headstock::agent
