#include "interpreter/machine_data.hpp"

#include <gtest/gtest.h>

namespace headstock::interp {
namespace {

const std::vector<char> kAxes = {'X', 'Z'};

TEST(MachineData, OffsetsRoundTrip) {
  MachineData data;
  ASSERT_EQ(
      load_offsets(R"({"external":{"X":1},"shift":{"Z":2},"work":{"G54":{"X":10,"Z":-20},"G54.1P48":{"Z":3}},
    "tools":{"12":{"geometry":{"X":-5.5},"wear":{"Z":0.01},"radius":0.4,"radius_wear":0.01,"tip":3}}})",
                   kAxes, data),
      "");
  EXPECT_EQ(data.work[0][1], -20);
  EXPECT_EQ(data.work_extra[47][1], 3);
  ASSERT_EQ(data.tools.size(), 13u);
  EXPECT_EQ(data.tools[12].geometry[0], -5.5);
  EXPECT_EQ(data.tools[12].tip, 3);
  EXPECT_EQ(data.version, 1u);
  MachineData again;
  ASSERT_EQ(load_offsets(offsets_to_json(data, kAxes), kAxes, again), "");
  EXPECT_EQ(again.work, data.work);
  EXPECT_EQ(again.work_extra, data.work_extra);
  EXPECT_EQ(again.work_shift, data.work_shift);
  EXPECT_EQ(again.tools[12].wear, data.tools[12].wear);
}

TEST(MachineData, MistakesNameTheirPlaceAndChangeNothing) {
  MachineData data;
  EXPECT_EQ(load_offsets(R"({"work":{"G54":{"X":1}},"tools":{"1":{"geometry":{"Y":1}}}})", kAxes, data),
            "tools/1/geometry/Y: the machine has no such axis");
  EXPECT_EQ(data.work[0][0], 0);
  EXPECT_EQ(load_offsets(R"({"work":{"G60":{}}})", kAxes, data), "work/G60: no such coordinate system");
  EXPECT_EQ(load_offsets(R"({"tools":{"0":{}}})", kAxes, data), "tools/0: must be a number from 1 to 999");
  EXPECT_EQ(load_offsets(R"({"tools":{"1":{"tip":12}}})", kAxes, data), "tools/1/tip: must be 0 to 9");
  EXPECT_EQ(load_offsets(R"({"offset":1})", kAxes, data),
            "offset: unknown key (external, shift, work, tools, tool_life)");
  EXPECT_NE(load_offsets("{", kAxes, data), "");
  EXPECT_EQ(load_offsets("[]", kAxes, data), "must be a JSON object");
  EXPECT_EQ(data.version, 0u);
}

TEST(MachineData, Parameters) {
  MachineData data;
  ASSERT_EQ(load_parameters(R"({"3401#0":true,"3410":0.05,"1241":{"X":100}})", data), "");
  EXPECT_TRUE(data.bit("3401#0"));
  EXPECT_EQ(data.parameter("3410"), 0.05);
  EXPECT_EQ(data.parameter("1241/X"), 100);
  EXPECT_EQ(data.parameter("9999", 7), 7);
  EXPECT_FALSE(data.bit(""));
  EXPECT_EQ(load_parameters(R"({"3410":"x"})", data), "3410: must be a number");
}

}  // namespace
}  // namespace headstock::interp
