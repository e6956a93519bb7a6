// What the coverage report may claim, and that the pages in the dialects' folders say what it says.
#include "command-line/offline/coverage.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "command-line/offline/off_panel.hpp"
#include "dialects/dialect.hpp"

namespace headstock::offline {
namespace {

const Covered* find(const std::vector<CoverageOf>& parts, std::string_view kind, std::string_view code) {
  for (const CoverageOf& part : parts) {
    if (part.kind != kind) continue;
    const auto found = std::find_if(part.items.begin(), part.items.end(),
                                    [code](const Covered& item) { return item.code == code; });
    return found == part.items.end() ? nullptr : &*found;
  }
  return nullptr;
}

TEST(Coverage, PatternsTakeBitsAndRangesButNoOtherLetters) {
  EXPECT_TRUE(matches("3402#0", "3402#0"));
  EXPECT_FALSE(matches("3402#0", "3402#1"));
  EXPECT_TRUE(matches("3400..3410", "3402#1"));
  EXPECT_TRUE(matches("3400..3410", "3406-3409"));
  EXPECT_FALSE(matches("3400..3410", "3411"));
  EXPECT_FALSE(matches("3400..3410", "P3402"));
  EXPECT_TRUE(matches("P154..P160", "P154"));
  EXPECT_TRUE(matches("SV*", "SV0401"));
  EXPECT_FALSE(matches("SV*", "SP0401"));
}

TEST(Coverage, IsDerivedFromWhatTheSourcesRaiseAndRead) {
  const auto fanuc = coverage("fanuc-0i-t");
  ASSERT_NE(find(fanuc, "alarms", "PS0077"), nullptr);
  EXPECT_EQ(find(fanuc, "alarms", "PS0077")->state, State::done);  // AlarmReason::nesting
  EXPECT_EQ(find(fanuc, "parameters", "3402#0")->state, State::done);
  EXPECT_EQ(find(fanuc, "alarms", "OT0500")->state, State::done);  // cited by the operation layer
  EXPECT_EQ(find(fanuc, "alarms", "SV0401")->state, State::off_panel);
  const auto gsk = coverage("gsk-2000tc");
  EXPECT_EQ(find(gsk, "parameters", "P154")->state, State::done);
  EXPECT_EQ(find(gsk, "gcodes", "G00")->state, State::done);
}

TEST(Coverage, NoReasonIsStale) {
  for (const auto profile : dialects::dialect_names())
    for (const std::string& row : stale_reasons(profile)) {
      // A row without a series speaks for both series of a shared folder.
      const bool shared = profile.starts_with("fanuc-0i") && row.find("the catalogue has no") != row.npos;
      if (!shared) ADD_FAILURE() << profile << ": " << row;
    }
}

TEST(Coverage, AnUnknownProfileHasNone) {
  EXPECT_TRUE(coverage("fanuc-31i").empty());
}

TEST(Coverage, ThePagesAreUpToDate) {
  for (const auto profile : dialects::dialect_names()) {
    std::ifstream file(HEADSTOCK_SOURCE_DIR "/controller-agent/dialects/" + std::string(profile) +
                       "/coverage.md");
    std::ostringstream page;
    page << file.rdbuf();
    EXPECT_TRUE(page.str() == coverage_page(profile)) << profile << ": build the target coverage_pages";
  }
}

}  // namespace
}  // namespace headstock::offline
