// What each controller lets a person write, and when. One row a rule.
#include "dialects/data_rules.hpp"

#include <gtest/gtest.h>

namespace headstock::dialects {
namespace {

using interp::MachineData;
constexpr Situation kIdle{false, true, true}, kRunning{true, false, true};

struct Case {
  const char* profile;
  std::map<std::string, double, std::less<>> parameters;
  const char* what;
  std::optional<double> value;
  Situation situation;
  const char* refusal;
};

class Rules : public testing::TestWithParam<Case> {};

TEST_P(Rules, AreKept) {
  const Case& c = GetParam();
  const std::string profile = c.profile;
  const std::vector<char> axes =
      profile == "fanuc-0i-m" ? std::vector<char>{'X', 'Y', 'Z'} : std::vector<char>{'X', 'Z'};
  MachineData data;
  data.parameters = c.parameters;
  EXPECT_EQ(refuse_value(*find(profile), data, axes, c.what, c.value, c.situation), c.refusal)
      << profile << " " << c.what;
}

INSTANTIATE_TEST_SUITE_P(
    Controllers, Rules,
    testing::Values(
        // 0i-D: numbers (8136#5 NDO), memory (8136#6 NGW), range (5042), L66000, L66009, L60105
        Case{"fanuc-0i-t", {}, "tool/200/wear/X", 0.1, kIdle, ""},
        Case{"fanuc-0i-t", {}, "tool/201/wear/X", 0.1, kIdle, "bad_place"},
        Case{"fanuc-0i-t", {{"8136#5", 1}}, "tool/65/wear/X", 0.1, kIdle, "bad_place"},
        Case{"fanuc-0i-t", {{"8136#6", 1}}, "tool/1/wear/X", 0.1, kIdle, "bad_place"},
        Case{"fanuc-0i-t", {}, "tool/1/geometry/X", 9'999.999, kIdle, ""},
        Case{"fanuc-0i-t", {}, "tool/1/geometry/X", 10'000.0, kIdle, "out_of_range"},
        Case{"fanuc-0i-t", {{"5042#0", 1}}, "tool/1/geometry/X", -9'999.995, kIdle, "out_of_range"},
        Case{"fanuc-0i-t", {}, "tool/1/tip", 9.0, kIdle, ""},
        Case{"fanuc-0i-t", {}, "tool/1/tip", 4.5, kIdle, "out_of_range"},
        Case{"fanuc-0i-t", {}, "tool/1/wear/Y", 0.1, kIdle, "bad_place"},
        Case{"fanuc-0i-m", {}, "tool/400/radius", 5.0, kIdle, ""},
        Case{"fanuc-0i-m", {}, "tool/1/geometry/Z", 120.0, kIdle, ""},
        Case{"fanuc-0i-m", {}, "tool/1/geometry/X", 1.0, kIdle, "bad_place"},
        Case{"fanuc-0i-m", {{"8136#6", 1}}, "tool/1/radius", 5.0, kIdle, "bad_place"},  // memory A: one value
        Case{"fanuc-0i-m", {{"8136#6", 1}}, "tool/1/geometry/Z", 5.0, kIdle, ""},
        Case{"fanuc-0i-m", {}, "work/G54.1P48/Y", 5.0, kIdle, ""},
        Case{"fanuc-0i-t", {}, "work/G54.1P1/X", 5.0, kIdle, "bad_place"},
        // While a program runs: lengths are taken by the next T or H (L59777); a radius would bend the
        // contour.
        Case{"fanuc-0i-t", {}, "tool/1/wear/X", 0.1, kRunning, ""},
        Case{"fanuc-0i-t", {}, "tool/1/radius", 0.4, kRunning, "running"},
        Case{"fanuc-0i-t", {}, "tool/1/tip", 3.0, kRunning, "running"},
        Case{"fanuc-0i-t", {}, "work/G54/X", 0.1, kRunning, "running"},
        Case{"fanuc-0i-t", {}, "variable/500", 1.0, kRunning, "running"},
        Case{"gsk-218t", {}, "tool/1/wear/X", 0.1, kRunning, "running"},  // L3463
        Case{"gsk-2000tc", {}, "tool/1/wear/X", 0.1, kRunning, "running"},
        // Locked ones: GSK 2000TC P093, P094 (L13203); 0i-D 6031, 6032 (L61383)
        Case{"gsk-2000tc", {{"P093", 10}, {"P094", 3}}, "tool/12/geometry/X", 1.0, kIdle, "locked"},
        Case{"gsk-2000tc", {{"P093", 10}, {"P094", 3}}, "tool/13/geometry/X", 1.0, kIdle, ""},
        Case{"fanuc-0i-t", {{"6031", 510}, {"6032", 520}}, "variable/515", 1.0, kIdle, "locked"},
        Case{"fanuc-0i-t", {{"6031", 510}, {"6032", 520}}, "variable/521", 1.0, kIdle, ""},
        // A single input of wear: GSK 2000TC P140, 1 mm unless set (L13471)
        Case{"gsk-2000tc", {}, "tool/1/wear/X", 1.001, kIdle, "wear_step"},
        Case{"gsk-2000tc", {{"P140", 2}}, "tool/1/wear/X", 1.001, kIdle, ""},
        // K2000TC: wear within P3220, R within 100 (L15109, L15849)
        Case{"k2000tc", {{"P3220", 5}}, "tool/1/wear/X", -5.001, kIdle, "out_of_range"},
        Case{"k2000tc", {{"P3220", 5}}, "tool/1/wear/X", 5.0, kIdle, ""},
        Case{"k2000tc", {}, "tool/1/radius", 100.5, kIdle, "out_of_range"},
        Case{"k2000tc", {}, "tool/33/geometry/X", 1.0, kIdle, "bad_place"},
        Case{"lathe-200t", {}, "tool/9/geometry/X", 1.0, kIdle, ""},
        Case{"lathe-200t", {}, "work/G54/X", 1.0, kIdle, "bad_place"},
        Case{"lathe-200t", {}, "variable/205", 1.0, kIdle, ""},
        Case{"lathe-200t", {}, "variable/500", 1.0, kIdle, "bad_place"},
        Case{"fanuc-0i-t", {}, "variable/200", 1.0, kIdle, "bad_place"},
        // Parameters: known, in range, switch on, MDI or emergency stop (0i-D II-12.4.1, L45401)
        Case{"fanuc-0i-t", {}, "parameter/6713", 50.0, kIdle, ""},
        Case{"fanuc-0i-t", {}, "parameter/6713", -1.0, kIdle, "out_of_range"},
        Case{"fanuc-0i-t", {}, "parameter/3402#0", 2.0, kIdle, "out_of_range"},
        Case{"fanuc-0i-t", {}, "parameter/99999", 1.0, kIdle, "bad_place"},
        Case{"fanuc-0i-t", {}, "parameter/6713", 50.0, Situation{false, true, false}, "parameter_write_off"},
        Case{"fanuc-0i-t", {}, "parameter/6713", 50.0, Situation{false, false, true}, "not_mdi"},
        Case{"fanuc-0i-t", {}, "parameter/6713", 50.0, kRunning, "running"},
        Case{"fanuc-0i-t", {}, "nonsense/1", 1.0, kIdle, "bad_place"},
        Case{"fanuc-0i-t", {}, "tool/1/wear/X", std::nullopt, kIdle, "out_of_range"}));

TEST(ParameterRange, IsReadWhereItIsOne) {
  const auto range = [](const char* text) {
    const auto found = parameter_range(text);
    return found ? std::to_string(found->least) + " " + std::to_string(found->most) : std::string("none");
  };
  EXPECT_EQ(range("0/1"), range("0..1"));
  EXPECT_EQ(range("500..999"), "500.000000 999.000000");
  EXPECT_EQ(range("0-9999"), "0.000000 9999.000000");
  EXPECT_EQ(range("-9999.9999..9999.9999"), "-9999.999900 9999.999900");
  EXPECT_EQ(range("+-9999999"), "-9999999.000000 9999999.000000");
  EXPECT_EQ(range("0-30000 (table: stepper 1-10000, servo 1-30000)"), "0.000000 30000.000000");
  for (const char* none :
       {"", "?", "see meaning", "std table A (IS-B -999999.999..+999999.999)", "101,102,103,..",
        "0..number of controlled axes", "8 bits, not 00h", "normal, reverse"})
    EXPECT_EQ(range(none), "none") << none;
}

TEST(OffsetPage, IsTheControllers) {
  const MachineData none;
  EXPECT_EQ(offset_page(*find("fanuc-0i-m"), none).numbers, 400u);
  EXPECT_EQ(offset_page(*find("fanuc-0i-m"), none).memory, 'C');
  EXPECT_EQ(offset_page(*find("fanuc-0i-m"), none).extra_systems, 48);
  EXPECT_EQ(offset_page(*find("gsk-2000tc"), none).numbers, 32u);
  EXPECT_EQ(offset_page(*find("gsk-218t"), none).numbers, 64u);
  EXPECT_EQ(offset_page(*find("lathe-200t"), none).work_systems, 0);
  EXPECT_TRUE(offset_page(*find("k2000tc"), none).lathe);
}

}  // namespace
}  // namespace headstock::dialects
