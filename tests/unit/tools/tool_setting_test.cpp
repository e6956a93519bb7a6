// Entries of the offset pages with the manuals' own numbers, and what a program sees of them.
#include "tools/tool_setting.hpp"

#include <gtest/gtest.h>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"

namespace headstock::tools {
namespace {

TEST(ToolSetting, TrialCutOfThe218T) {  // E18, L740
  EXPECT_DOUBLE_EQ(measured_offset({.shown = 105, .place = 104}), 1);
}

TEST(ToolSetting, IncrementsAreAdded) {  // 218T E19, 2000TC E37
  EXPECT_NEAR(corrected_offset(5.678, 1.5), 7.178, 1e-12);
}

TEST(ToolSetting, FixedPointTakesTheRelativePage) {  // 218T L697, 2000TC L8519
  EXPECT_DOUBLE_EQ(fixed_point_offset(-12.5), -12.5);
  EXPECT_DOUBLE_EQ(fixed_point_offset(-12.5, 2), -10.5);
}

TEST(ToolSetting, TrimOfThe200T) {  // E41: 0.057 too big, 0.238 short
  EXPECT_DOUBLE_EQ(trimmed_offset(1, -0.057), 1.057);
  EXPECT_DOUBLE_EQ(trimmed_offset(1, 0.238), 0.762);
}

// Where the slide stands and what the page shows of it, by a program that does not move.
double shown_x(const char* profile, double offset, const std::string& t) {
  const machine::Machine machine = *machine::default_machine(profile);
  interp::MachineData data;
  std::vector<char> names;
  for (const auto& axis : machine.axes) names.push_back(axis.name);
  EXPECT_EQ(interp::load_offsets(
                R"({"tools": {"1": {"geometry": {"X": )" + std::to_string(offset) + "}}}}", names, data),
            "");
  interp::Interpreter interpreter(*dialects::find(profile), machine, data, nullptr);
  machine::AxisVector at{};
  at[0] = 50;  // slide mm: X100 on the page
  const std::string program = t + "\nG00 U0\nM02\n";
  interpreter.start(program::source_from_text(program), at);
  interp::Operation operation;
  double shown = -1;
  while (interpreter.next(operation) == interp::Pull::operation) {
    if (const auto* rapid = std::get_if<interp::Rapid>(&operation)) shown = rapid->end_work[0];
  }
  return shown;
}

// After the entry the page shows the measured diameter with the slide where it stood.
TEST(ToolSetting, ThePageShowsTheMeasuredValueAfterwards) {
  const double diameter = 42.5;
  for (const double stored : {0.0, 3.0}) {
    const double before = shown_x("fanuc-0i-t", stored, "T0101");
    const double fanuc = measured_offset({.shown = before, .place = diameter, .in_force = stored});
    EXPECT_NEAR(shown_x("fanuc-0i-t", fanuc, "T0101"), diameter, 1e-9);
    const double before_200t = shown_x("lathe-200t", stored, "T0101");
    const double own = measured_offset({.shown = before_200t, .place = diameter, .in_force = stored}, OffsetSign::added);
    EXPECT_NEAR(shown_x("lathe-200t", own, "T0101"), diameter, 1e-9);
  }
}

}  // namespace
}  // namespace headstock::tools
