#include <gtest/gtest.h>

#include "server/api/http/web_server.hpp"

namespace headstock::api {
namespace {

TEST(Target, IsSplitAndDecoded) {
  std::string path;
  std::map<std::string, std::string> query;
  ASSERT_TRUE(split_target("/api/v1/programs?folder=%2Fa%2Fb&q=x+y&empty=&flag", path, query));
  EXPECT_EQ(path, "/api/v1/programs");
  EXPECT_EQ(query.at("folder"), "/a/b");
  EXPECT_EQ(query.at("q"), "x y");
  EXPECT_EQ(query.at("empty"), "");
  EXPECT_EQ(query.at("flag"), "");
}

TEST(Target, MalformedOnesAreRefused) {
  std::string path;
  std::map<std::string, std::string> query;
  for (const char* bad : {"", "x", "*", "/%", "/%4", "/%zz", "/a%00b", "/a?x=%0", "/a?%00=1"})
    EXPECT_FALSE(split_target(bad, path, query)) << bad;
}

TEST(Cookies, TheNameMustMatchWhole) {
  EXPECT_EQ(cookie_value("a=1; headstock_session=abc; b=2", session_cookie), "abc");
  EXPECT_EQ(cookie_value("headstock_session=abc", session_cookie), "abc");
  EXPECT_EQ(cookie_value("xheadstock_session=abc", session_cookie), "");
  EXPECT_EQ(cookie_value("headstock_session2=abc", session_cookie), "");
  EXPECT_EQ(cookie_value("", session_cookie), "");
}

}  // namespace
}  // namespace headstock::api
