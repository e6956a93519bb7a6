// The real interpreter and kernel behind a check.
#include "server/library/checks.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/unit/db/shop_database.hpp"

namespace headstock::library {
namespace {

struct ChecksTest : testing::Test {
  test::TemporaryFolder folder;

  CheckJob job(const std::string& text, const char* profile = "fanuc-0i-t") {
    const auto file = folder / "program";
    std::ofstream(file, std::ios::binary) << text;
    CheckJob made;
    made.file = file.string();
    made.machine.profile = profile;
    return made;
  }
};

TEST_F(ChecksTest, AGoodProgramIsTimed) {
  const CheckResult result = run_check(job(
      "%\nO1001\nG28 U0 W0\nT0101\nG97 S1000 M03\nG00 X20. Z2.\nG98 G01 Z-60. F120.\nG00 X40.\nM30\n%\n"));
  EXPECT_TRUE(result.ok) << to_json(result).dump(2);
  EXPECT_TRUE(result.timed);
  EXPECT_GT(result.cutting_s, 30.0);  // 62 mm at 120 mm/min is 31 s
  EXPECT_LT(result.cutting_s, 33.0);
  EXPECT_GT(result.time_s, result.cutting_s);
  ASSERT_EQ(result.bounds.size(), 2u);
  EXPECT_EQ(result.bounds[0].axis, "X");
  EXPECT_EQ(result.tools, std::vector<std::int64_t>{1});
}

TEST_F(ChecksTest, MistakesAreTheControllersOwnAlarms) {
  const CheckResult result = run_check(job("O1001\nG98 G01 X10. F100.\nG999\nM30\n"));
  EXPECT_FALSE(result.ok);
  ASSERT_FALSE(result.findings.empty());
  EXPECT_EQ(result.findings[0].code, "PS0010");
  EXPECT_EQ(result.findings[0].line, 3);
  EXPECT_NE(result.findings[0].en, "");
  EXPECT_NE(result.findings[0].zh, "");
}

TEST_F(ChecksTest, FeedPerRevolutionWithoutASpindleIsFound) {
  const CheckResult result = run_check(job("O1001\nG99 G01 X10. F0.2\nM30\n"));
  EXPECT_FALSE(result.ok);
  ASSERT_EQ(result.findings.size(), 1u);
  EXPECT_EQ(result.findings[0].code, "stuck");
}

TEST_F(ChecksTest, TheMachinesOwnLimitsCount) {
  CheckJob over = job("O1\nG98 G01 Z-150. F1000.\nM30\n");
  over.machine.toml = "[axis.Z]\nmin_mm = -100.0\n";
  const CheckResult result = run_check(over);
  EXPECT_FALSE(result.ok);
  ASSERT_FALSE(result.findings.empty());
  EXPECT_EQ(result.findings[0].line, 2);
  over.machine.toml = "[axis.Z]\nmin_mm = -400.0\n";
  EXPECT_TRUE(run_check(over).ok) << to_json(run_check(over)).dump(2);
}

TEST_F(ChecksTest, ReportedOffsetsCount) {
  CheckJob shifted = job("O1\nG54 G98 G01 Z-150. F1000.\nM30\n");
  shifted.machine.toml = "[axis.Z]\nmin_mm = -200.0\n";
  EXPECT_TRUE(run_check(shifted).ok);
  shifted.machine.offsets_json = R"({"work":{"G54":{"Z":-100.0}}})";
  EXPECT_FALSE(run_check(shifted).ok);
}

TEST_F(ChecksTest, SubProgramsComeFromTheSameFolder) {
  const CheckJob caller = job("O1\nM98 P2000\nM30\n", "fanuc-0i-m");
  EXPECT_FALSE(run_check(caller).ok);
  CheckJob with = caller;
  std::ofstream(folder / "sub") << "O2000\nG01 X1. F100.\nM99\n";
  with.subprograms["O2000.nc"] = (folder / "sub").string();
  EXPECT_TRUE(run_check(with).ok) << to_json(run_check(with)).dump(2);
}

TEST_F(ChecksTest, AProgramTooLongToTimeIsReadToItsEnd) {
  std::string text = "O1\nG94 F1000.\n";
  for (int i = 0; i < 20'000; ++i) text.append(i % 2 == 0 ? "G01 X1. Y1.\n" : "G01 X0. Y0.\n");
  CheckJob slow = job(text + "M30\n", "fanuc-0i-m");
  slow.max_wall_ms = 1;
  const CheckResult good = run_check(slow);
  EXPECT_TRUE(good.ok) << to_json(good).dump(2);
  EXPECT_FALSE(good.timed);
  CheckJob bad = job(text + "G999\nM30\n", "fanuc-0i-m");
  bad.max_wall_ms = 1;
  const CheckResult result = run_check(bad);
  EXPECT_FALSE(result.ok);
  ASSERT_FALSE(result.findings.empty());
  EXPECT_EQ(result.findings[0].line, 20'003);
}

TEST_F(ChecksTest, BadTextsAreFindingsNeverCrashes) {
  using namespace std::string_literals;
  for (const std::string& text :
       {"\0\0\0"s, std::string(1'000'000, 'X'), "(\xB4\xD6\xB3\xB5)\n"s, "\xFF\xFE\n"s, "((((("s})
    for (const char* profile :
         {"fanuc-0i-t", "fanuc-0i-m", "gsk-2000tc", "gsk-218t", "k2000tc", "lathe-200t"})
      EXPECT_LE(run_check(job(text, profile)).findings.size(), 100u);
  CheckJob nowhere = job("M30\n", "no such profile");
  EXPECT_FALSE(run_check(nowhere).ok);
}

TEST_F(ChecksTest, BackplotHasTheLinesOfTheSource) {
  const Backplot plot = run_backplot(job("O1\nG00 X20. Z2.\nG98 G01 Z-10. F100.\nM30\n"), 1'000);
  EXPECT_EQ(plot.axes, (std::vector<std::string>{"X", "Z"}));
  ASSERT_GE(plot.moves.size(), 2u);
  EXPECT_EQ(plot.moves.back().line, 3);
  EXPECT_EQ(plot.moves.back().kind, 'f');
  EXPECT_EQ(plot.moves.back().points.size() % 2, 0u);
}

TEST_F(ChecksTest, ResultsSurviveTheirJson) {
  const CheckResult result = run_check(job("O1001\nG01 X10. F100.\nG999\nM30\n"));
  EXPECT_EQ(to_json(check_result_from_json(to_json(result))), to_json(result));
}

}  // namespace
}  // namespace headstock::library
