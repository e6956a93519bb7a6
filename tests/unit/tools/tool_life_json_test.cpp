#include "tools/tool_life_json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "interpreter/machine_data.hpp"

namespace headstock::tools {
namespace {

TEST(ToolLifeJson, ReadsBackWhatItWrote) {
  const char* const text =
      R"({"1": {"unit": "uses", "life": 10, "current": 1, "tools": [{"tool": 10, "offset": 1, "used": 10},
                                              {"tool": 11, "h": 2, "d": 3, "used": 4, "skipped": true}]},
          "7": {"unit": "seconds", "life": 3600.5, "current": 0, "tools": [{"tool": 3, "used": 0.1}]}})";
  LifeTable table, again;
  ASSERT_EQ(read_life(nlohmann::json::parse(text), table), "");
  EXPECT_EQ(table.groups.at(7).life, 36'005);
  EXPECT_TRUE(table.groups.at(1).tools.at(1).skipped);
  EXPECT_EQ(life_to_json(table), nlohmann::json::parse(text));
  ASSERT_EQ(read_life(life_to_json(table), again), "");
  EXPECT_EQ(again.groups, table.groups);
}

TEST(ToolLifeJson, SaysWhatIsWrongAndWhere) {
  const auto mistake = [](const char* text) {
    LifeTable table;
    table.groups[5].life = 1;
    const std::string wrong = read_life(nlohmann::json::parse(text), table);
    EXPECT_EQ(table.groups.size(), 1u) << text;
    return wrong;
  };
  EXPECT_EQ(mistake("[]"), "tool_life: must be an object of group numbers");
  EXPECT_EQ(mistake(R"({"x": {}})"), "tool_life/x: must be a group number");
  EXPECT_EQ(mistake(R"({"0": {}})"), "tool_life/0: must be a group number");
  EXPECT_EQ(mistake(R"({"1": {}})"), "tool_life/1/life: must be more than 0");
  EXPECT_EQ(mistake(R"({"1": {"life": -1}})"), "tool_life/1/life: must be a number from 0");
  EXPECT_EQ(mistake(R"({"1": {"life": 1.5}})"), "tool_life/1/life: must be a whole number");
  EXPECT_EQ(mistake(R"({"1": {"life": 1, "unit": "kg"}})"), "tool_life/1/unit: must be uses or seconds");
  EXPECT_EQ(mistake(R"({"1": {"life": 1, "current": 1, "tools": [{"tool": 1}]}})"),
            "tool_life/1/current: the group has no such tool");
  EXPECT_EQ(mistake(R"({"1": {"life": 1, "tools": [{"tol": 1}]}})"), "tool_life/1/tools/0/tol: unknown key");
}

TEST(ToolLifeJson, IsPartOfTheOffsets) {
  interp::MachineData data;
  ASSERT_EQ(
      interp::load_offsets(R"({"tool_life": {"1": {"life": 3, "tools": [{"tool": 2}]}}})", {'X', 'Z'}, data),
      "");
  ASSERT_NE(data.tool_life.find(1), nullptr);
  interp::MachineData again;
  ASSERT_EQ(interp::load_offsets(interp::offsets_to_json(data, {'X', 'Z'}), {'X', 'Z'}, again), "");
  EXPECT_EQ(again.tool_life.groups, data.tool_life.groups);
}

}  // namespace
}  // namespace headstock::tools
