#include "protocol/tape/machine_data.hpp"

#include <gtest/gtest.h>

namespace headstock::tape {
namespace {

using Entries = std::vector<DataEntry>;

TEST(MachineData, EveryFormBecomesItemsAndValues) {
  EXPECT_EQ(machine_data("%\nG10 P01 X0.1 Z-1.25 R0.4 Q3\nG10 P10001 X1. Z2.\n%\n"),
            (Entries{{"P01 X", "0.1"},
                     {"P01 Z", "-1.25"},
                     {"P01 R", "0.4"},
                     {"P01 Q", "3"},
                     {"P10001 X", "1."},
                     {"P10001 Z", "2."}}));
  EXPECT_EQ(machine_data("G10 L2 P1 X-200. Y0\n"), (Entries{{"L2 P1 X", "-200."}, {"L2 P1 Y", "0"}}));
  EXPECT_EQ(machine_data("N01320 Q1 A1 P500 A2 P-600\nN00020 P4\n"),
            (Entries{{"No.01320 A1", "500"}, {"No.01320 A2", "-600"}, {"No.00020", "4"}}));
  EXPECT_EQ(machine_data("017 2\n001\t00011000\n"), (Entries{{"No.017", "2"}, {"No.001", "00011000"}}));
  EXPECT_EQ(machine_data("G10 L85 P500(4028000000000000)\nM02\n"), (Entries{{"#500", "4028000000000000"}}));
  EXPECT_EQ(machine_data("G10 L3\nP1 L30 Q2\nT11 H11 D11\nT12\nG11\n"),
            (Entries{{"group 1 life", "30"},
                     {"group 1 kind", "2"},
                     {"group 1 tool 1", "T11H11D11"},
                     {"group 1 tool 2", "T12"}}));
}

TEST(MachineData, WhatIsNotUnderstoodIsShownAsItIs) {
  EXPECT_EQ(machine_data("SETVN500[DEPTH,WIDTH]\n"), (Entries{{"SETVN500[DEPTH,WIDTH]", ""}}));
}

TEST(MachineData, DifferencesNameBothSides) {
  const auto found =
      changes(machine_data("G10 P01 X0.1 Z0\nG10 P02 X5.\n"), machine_data("G10 P01 X0.2 Z0\nG10 P03 X1.\n"));
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].item, "P01 X");
  EXPECT_EQ(found[0].before, "0.1");
  EXPECT_EQ(found[0].after, "0.2");
  EXPECT_EQ(found[1].item, "P03 X");
  EXPECT_FALSE(found[1].before);
  EXPECT_EQ(found[2].item, "P02 X");
  EXPECT_FALSE(found[2].after);
}

TEST(MachineData, ValuesByTheNamesOfTheMachinesPages) {
  using Named = std::vector<NamedValue>;
  EXPECT_EQ(named_values("%\nG10 P03 X0.1 Z-0.05 R0.4 Q3\nG10 P10003 X12.5 R0.8\n%\n"),
            (Named{{"tool/3/wear/X", 0.1},
                   {"tool/3/wear/Z", -0.05},
                   {"tool/3/radius_wear", 0.4},
                   {"tool/3/tip", 3},
                   {"tool/3/geometry/X", 12.5},
                   {"tool/3/radius", 0.8}}));
  EXPECT_EQ(named_values("G10 G90 L10 P1 R120.5\nG10 L11 P1 R-.5\nG10 L12 P2 R5.\nG10 L13 P2 R0.02\n"),
            (Named{{"tool/1/geometry/Z", 120.5},
                   {"tool/1/wear/Z", -0.5},
                   {"tool/2/radius", 5},
                   {"tool/2/radius_wear", 0.02}}));
  EXPECT_EQ(named_values("G10 L2 P1 X-200. Y0\nG10 L2 P0 Z1.\nG10 L20 P7 X3.\n"),
            (Named{{"work/G54/X", -200}, {"work/G54/Y", 0}, {"work/EXT/Z", 1}, {"work/G54.1P7/X", 3}}));
  EXPECT_EQ(named_values("G10 L85 P500(4028000000000000)\nG10 L85 P501(FFFFFFFFFFFFFFFF)\n"),
            (Named{{"variable/500", 12}}))
      << "0/0 is an empty variable";
  EXPECT_TRUE(named_values("N01320 A1 P500\nG00 X1.\n").empty());
}

}  // namespace
}  // namespace headstock::tape
