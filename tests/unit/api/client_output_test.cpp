#include "command-line/client/output.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstdlib>

#include "command-line/client/connection.hpp"

namespace headstock::client {
namespace {

TEST(Output, LanguageFromTheOptionOrTheEnvironment) {
  ::setenv("LC_ALL", "zh_CN.UTF-8", 1);
  choose_language("");
  EXPECT_EQ(say("yes", "是"), "是");
  choose_language("en");
  EXPECT_EQ(say("yes", "是"), "yes");
  ::unsetenv("LC_ALL");
}

TEST(Output, ColumnsAreAlignedByWhatIsSeen) {
  EXPECT_EQ(display_width("abc"), 3u);
  EXPECT_EQ(display_width("机床"), 4u);
  EXPECT_EQ(table({"a", "b"}, {{"机床", "x"}, {"abc", "y"}}), "a     b\n机床  x\nabc   y\n");
}

TEST(Output, UnknownIsADashNeverZero) {
  EXPECT_EQ(cell(nullptr), "–");
  EXPECT_EQ(duration(nullptr), "–");
  EXPECT_EQ(local_time(nullptr), "–");
  EXPECT_EQ(duration(3723), "1 h 02 min 03 s");
  EXPECT_EQ(duration(63), "1 min 03 s");
  EXPECT_EQ(duration(1.25), "1.2 s");
}

TEST(Connection, AddressesWithoutASchemeAreRefused) {
  for (const char* bad : {"127.0.0.1:8080", "ftp://x", ""}) EXPECT_THROW(Connection({bad, "", ""}), Failure) << bad;
}

TEST(Connection, NobodyThereIsUnreachable) {
  try {
    Connection({"http://127.0.0.1:1", "", ""}).get("/health");
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status(), unreachable);
  }
}

TEST(Connection, QueriesAreEncoded) { EXPECT_EQ(encoded("/a b&机"), "%2Fa%20b%26%E6%9C%BA"); }

}  // namespace
}  // namespace headstock::client
