// Values of a machine by name: read, write, and all of them.
#include "interpreter/data_values.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace headstock::interp {
namespace {

const std::vector<char> kAxes = {'X', 'Z'};
constexpr std::size_t kTools = 99;

std::map<std::string, double> all_of(const MachineData& data) {
  std::map<std::string, double> all;
  each_value(data, kAxes, [&](const std::string& what, double value) { all[what] = value; });
  return all;
}

TEST(DataValues, WhatIsWrittenIsReadUnderTheSameName) {
  MachineData data;
  for (const char* what : {"tool/3/geometry/X", "tool/3/wear/Z", "tool/99/radius", "tool/1/radius_wear",
                           "work/G54/X", "work/G54.1P48/Z", "work/EXT/X", "work/shift/Z", "parameter/3402#0",
                           "parameter/1241/X", "parameter/S001.0", "variable/500", "variable/100"}) {
    ASSERT_TRUE(write_value(data, kAxes, what, 1.25, kTools)) << what;
    const ValueRead read = read_value(data, kAxes, what);
    EXPECT_TRUE(read.known) << what;
    EXPECT_EQ(read.value, 1.25) << what;
    EXPECT_EQ(all_of(data).at(what), 1.25);
  }
  ASSERT_TRUE(write_value(data, kAxes, "tool/3/tip", 8, kTools));
  EXPECT_EQ(read_value(data, kAxes, "tool/3/tip").value, 8);
  EXPECT_EQ(data.tools[3].tip, 8);
}

TEST(DataValues, WhatAMachineHasNoPlaceForIsRefused) {
  MachineData data;
  for (const char* what : {"tool/0/geometry/X",
                           "tool/100/geometry/X",
                           "tool/3/geometry/Y",
                           "tool/3/geometry",
                           "tool/3/length",
                           "tool//geometry/X",
                           "tool/3x/geometry/X",
                           "tool/3/tip/X",
                           "work/G53/X",
                           "work/G60/X",
                           "work/G54.1P49/X",
                           "work/G54.1P0/X",
                           "work/G54/Q",
                           "work/G54/X/Z",
                           "variable/",
                           "variable/x",
                           "variable/1/2",
                           "parameter/",
                           "parameter/a b",
                           "tool_life/0/life",
                           "",
                           "tool",
                           "tool/3/geometry/X/1/2",
                           "something/3"}) {
    EXPECT_FALSE(write_value(data, kAxes, what, 1, kTools)) << what;
  }
  EXPECT_TRUE(all_of(data).empty());
}

TEST(DataValues, ATipIsAWholeNumberFrom0To9AndNothingIsInfinite) {
  MachineData data;
  EXPECT_FALSE(write_value(data, kAxes, "tool/1/tip", 10, kTools));
  EXPECT_FALSE(write_value(data, kAxes, "tool/1/tip", 1.5, kTools));
  EXPECT_FALSE(write_value(data, kAxes, "tool/1/tip", -1, kTools));
  EXPECT_FALSE(write_value(data, kAxes, "tool/1/wear/X", std::nan(""), kTools));
  EXPECT_FALSE(write_value(data, kAxes, "variable/500", HUGE_VAL, kTools));
  EXPECT_FALSE(write_value(data, kAxes, "tool/1/wear/X", std::nullopt, kTools))
      << "an offset is never nothing";
}

TEST(DataValues, VariablesAndParametersCanBeErased) {
  MachineData data;
  write_value(data, kAxes, "variable/500", 0, kTools);
  EXPECT_EQ(all_of(data).size(), 1u) << "0 is not nothing";
  EXPECT_TRUE(write_value(data, kAxes, "variable/500", std::nullopt, kTools));
  EXPECT_TRUE(read_value(data, kAxes, "variable/500").known);
  EXPECT_FALSE(read_value(data, kAxes, "variable/500").value);
  write_value(data, kAxes, "parameter/1410", 5, kTools);
  EXPECT_TRUE(write_value(data, kAxes, "parameter/1410", std::nullopt, kTools));
  EXPECT_TRUE(all_of(data).empty());
}

TEST(DataValues, AToolLifeGroupIsWrittenUnitLifeTools) {
  MachineData data;
  EXPECT_FALSE(write_value(data, kAxes, "tool_life/2/tool/0", 20, kTools)) << "no such group yet";
  ASSERT_TRUE(write_value(data, kAxes, "tool_life/2/unit", 1, kTools));
  ASSERT_TRUE(write_value(data, kAxes, "tool_life/2/life", 3600, kTools));
  EXPECT_FALSE(write_value(data, kAxes, "tool_life/2/tool/1", 20, kTools)) << "the first comes first";
  ASSERT_TRUE(write_value(data, kAxes, "tool_life/2/tool/0", 20, kTools));
  ASSERT_TRUE(write_value(data, kAxes, "tool_life/2/tool/1", 21, kTools));
  ASSERT_TRUE(write_value(data, kAxes, "tool_life/2/used/0", 12.5, kTools));
  ASSERT_TRUE(write_value(data, kAxes, "tool_life/2/skipped/1", 1, kTools));
  ASSERT_TRUE(write_value(data, kAxes, "tool_life/2/current", 1, kTools));
  EXPECT_FALSE(write_value(data, kAxes, "tool_life/2/current", 2, kTools));
  EXPECT_FALSE(write_value(data, kAxes, "tool_life/2/unit", 0, kTools)) << "seconds counted are no uses";
  EXPECT_FALSE(write_value(data, kAxes, "tool_life/2/life", 0, kTools));
  const tools::LifeGroup& group = data.tool_life.groups.at(2);
  EXPECT_EQ(group.life, 36'000) << "tenths of a second";
  EXPECT_EQ(group.tools[0].used, 125);
  EXPECT_TRUE(group.tools[1].skipped);
  EXPECT_EQ(all_of(data).at("tool_life/2/used/0"), 12.5);
  EXPECT_TRUE(write_value(data, kAxes, "tool_life/2/life", std::nullopt, kTools));
  EXPECT_TRUE(data.tool_life.groups.empty());
}

/// What each_value tells, written into an empty machine, makes the same machine: a restore loses nothing.
TEST(DataValues, AllValuesOfAMachineMakeItAgain) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> value(-500, 500);
  MachineData data;
  data.tools.resize(kTools + 1);
  for (std::size_t i = 1; i <= kTools; ++i) {
    data.tools[i].geometry = {value(random), value(random)};
    data.tools[i].wear = {value(random), value(random)};
    data.tools[i].radius = value(random);
    data.tools[i].tip = static_cast<int>(random() % 10);
  }
  for (auto& work : data.work) work = {value(random), value(random)};
  data.parameters = {{"1410", 3000}, {"3402#0", 1}, {"1241/X", 100}};
  data.common_variables = {{100, 1}, {500, -2.5}};
  tools::LifeGroup group;
  group.life = 10;
  group.tools = {{1, 1, 0, 0, 3, false}, {2, 2, 0, 0, 0, true}};
  data.tool_life.groups[7] = group;

  MachineData made;
  const auto all = all_of(data);
  for (const char* part : {"/unit", "/life", "/tool/", ""})
    for (const auto& [what, number] : all) {
      const bool life = what.starts_with("tool_life/");
      if (*part == '\0' || (life && what.find(part) != what.npos)) {
        EXPECT_TRUE(write_value(made, kAxes, what, number, kTools)) << what;
      }
    }
  EXPECT_EQ(all_of(made), all);
  EXPECT_EQ(made.tool_life.groups, data.tool_life.groups);
}

}  // namespace
}  // namespace headstock::interp
