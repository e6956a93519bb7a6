#include "web/assets.hpp"

#include <gtest/gtest.h>

#include <string>

namespace headstock::web {
namespace {

std::string plain(const Asset& asset) {
  std::string text(plain_size(asset), '\0');
  EXPECT_TRUE(unpack(asset, text.data()));
  return text;
}

TEST(Assets, ThePageIsFoundAtTheRoot) {
  const Asset* page = find("/");
  ASSERT_NE(page, nullptr);
  EXPECT_EQ(page, find("/index.html"));
  EXPECT_EQ(page->mime, "text/html; charset=utf-8");
  EXPECT_FALSE(page->immutable) << "the page must be asked for again after an update";
  EXPECT_NE(plain(*page).find("<div id=\"root\">"), std::string::npos);
}

TEST(Assets, EverythingThePageNamesIsThere) {
  const std::string page = plain(*find("/"));
  int named = 0;
  for (std::size_t at = page.find("\"/assets/"); at != std::string::npos;
       at = page.find("\"/assets/", at + 1)) {
    const std::string path = page.substr(at + 1, page.find('"', at + 1) - at - 1);
    const Asset* asset = find(path);
    ASSERT_NE(asset, nullptr) << path;
    EXPECT_TRUE(asset->immutable);
    EXPECT_TRUE(asset->gzip);
    EXPECT_EQ(plain(*asset).size(), plain_size(*asset));
    ++named;
  }
  EXPECT_GE(named, 2) << "a script and a style sheet";
}

TEST(Assets, NothingIsFetchedFromElsewhere) {
  EXPECT_EQ(plain(*find("/")).find("//"), std::string::npos) << "no other host";
}

TEST(Assets, UnknownPathsAreNotFound) {
  for (const char* path : {"/index", "/assets", "/assets/", "index.html", "/../etc/passwd", "/zzz"})
    EXPECT_EQ(find(path), nullptr) << path;
}

TEST(Assets, TheTagIsQuotedAndTellsFilesApart) {
  const auto tag = find("/")->etag;
  ASSERT_GT(tag.size(), 10u);
  EXPECT_EQ(tag.front(), '"');
  EXPECT_EQ(tag.back(), '"');
  EXPECT_NE(tag, find("/favicon.svg")->etag);
}

}  // namespace
}  // namespace headstock::web
