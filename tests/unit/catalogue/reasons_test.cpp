#include "protocol/wire/reasons.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tables/reasons.hpp"

namespace headstock::protocol {
namespace {

TEST(Reasons, AReasonHasBothLanguages) {
  EXPECT_EQ(reason_text("not_armed").en, "Remote operation is not armed at the machine");
  EXPECT_EQ(reason_text("not_armed").zh, "机床侧未授权远程操作");
  EXPECT_EQ(reason_text("bad_hash").key, "bad_hash");
}

TEST(Reasons, AnUnknownReasonIsShownByItsKey) {
  EXPECT_EQ(reason_text("of_a_newer_agent").en, "of_a_newer_agent");
  EXPECT_EQ(reason_text("of_a_newer_agent").zh, "of_a_newer_agent");
  EXPECT_EQ(reason_text("").en, "");
}

TEST(Reasons, EveryRowIsCompleteAndOnce) {
  std::set<std::string_view> keys;
  for (const auto& [key, en, zh] : tables::reasons) {
    EXPECT_TRUE(keys.insert(key).second) << key;
    EXPECT_EQ(key.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789"), std::string_view::npos) << key;
    EXPECT_FALSE(en.empty()) << key;
    EXPECT_GE(static_cast<unsigned char>(zh.empty() ? 0 : zh.front()), 0xe4) << key << ": Chinese text";
  }
}

}  // namespace
}  // namespace headstock::protocol
