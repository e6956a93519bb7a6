#include "machine/machine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

namespace headstock::machine {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

Machine parsed(std::string_view toml, std::string_view profile = {}) {
  const auto result = parse_machine(toml, "t.toml", profile);
  if (const auto* error = std::get_if<MachineError>(&result)) {
    ADD_FAILURE() << error->message;
    return {};
  }
  return std::get<Machine>(result);
}

std::string refusal(std::string_view toml, std::string_view profile = {}) {
  const auto result = parse_machine(toml, "t.toml", profile);
  const auto* error = std::get_if<MachineError>(&result);
  return error == nullptr ? "accepted" : error->message;
}

std::string axes_of(const Machine& machine) {
  std::string names;
  for (const Axis& axis : machine.axes) names += axis.name;
  return names;
}

TEST(DefaultMachine, EveryProfileIsALatheOrAMill) {
  for (const std::string_view profile : {"fanuc-0i-t", "gsk-2000tc", "gsk-218t", "k2000tc", "lathe-200t"}) {
    const auto lathe = default_machine(profile);
    ASSERT_TRUE(lathe) << profile;
    EXPECT_EQ(lathe->profile, profile);
    EXPECT_EQ(lathe->kind, Kind::lathe);
    ASSERT_EQ(axes_of(*lathe), "XZ");
    EXPECT_EQ(lathe->axes[0].designation, Designation::diameter);
    EXPECT_EQ(lathe->axes[1].designation, Designation::radius);
  }
  const auto mill = default_machine("fanuc-0i-m");
  ASSERT_TRUE(mill);
  EXPECT_EQ(mill->kind, Kind::mill);
  EXPECT_EQ(axes_of(*mill), "XYZ");
  EXPECT_EQ(mill->axes[0].designation, Designation::radius);
  EXPECT_FALSE(default_machine("fanuc-0i"));
  EXPECT_FALSE(default_machine(""));
}

TEST(MachineFile, EveryKeyOfTheContractIsRead) {
  const auto machine = parsed(R"(
[machine]
name = "车床 1"
profile = "fanuc-0i-t"
period_us = 2000
[path]
tolerance_mm = 0.02
tolerance_deg = 0.1
[axis.X]
rapid_mm_min = 7000
max_feed_mm_min = 3000
max_acceleration_mm_s2 = 1200.5
max_jerk_mm_s3 = 1e9
min_mm = -5
max_mm = 130
reference_mm = 130
backlash_um = 12
pitch_error = [[0, 0], [50, 3.5], [100, -2]]
[axis.C]
rapid_mm_min = 3600
[spindle]
max_rpm = 3500
min_rpm = 20
acceleration_rpm_s = 900
encoder_lines = 2048
[drive]
type = "simulated"
[memory]
programs_kb = 512
)");
  EXPECT_EQ(machine.name, "车床 1");
  EXPECT_EQ(machine.kind, Kind::lathe);
  EXPECT_EQ(machine.period_us, 2000);
  EXPECT_DOUBLE_EQ(machine.tolerance_mm, 0.02);
  EXPECT_DOUBLE_EQ(machine.tolerance_deg, 0.1);
  EXPECT_DOUBLE_EQ(machine.degrees_per_mm(), 5);
  ASSERT_EQ(axes_of(machine), "XZC");
  const Axis& x = machine.axes[0];
  EXPECT_EQ(x.rapid_mm_min, 7000);
  EXPECT_EQ(x.max_feed_mm_min, 3000);
  EXPECT_EQ(x.max_acceleration_mm_s2, 1200.5);
  EXPECT_EQ(x.max_jerk_mm_s3, 1e9);
  EXPECT_EQ(x.min_mm, -5);
  EXPECT_EQ(x.max_mm, 130);
  EXPECT_EQ(x.reference_mm, 130);
  EXPECT_EQ(x.backlash_um, 12);
  EXPECT_EQ(x.designation, Designation::diameter) << "kept from the profile";
  ASSERT_EQ(x.pitch_error.size(), 3u);
  EXPECT_EQ(x.pitch_error[1].position_mm, 50);
  EXPECT_EQ(x.pitch_error[1].error_um, 3.5);
  EXPECT_TRUE(machine.axes[2].rotary) << "A, B and C are rotary unless the file says otherwise";
  EXPECT_EQ(machine.spindle.max_rpm, 3500);
  EXPECT_EQ(machine.spindle.min_rpm, 20);
  EXPECT_EQ(machine.spindle.acceleration_rpm_s, 900);
  EXPECT_EQ(machine.spindle.encoder_lines, 2048);
  EXPECT_EQ(machine.program_memory_bytes, 512u * 1024);
}

TEST(MachineFile, AxesStandInTheFixedOrderWhateverTheFile) {
  const auto machine = parsed("[axis.C]\n[axis.A]\nrapid_mm_min = 100\n[axis.W]\n[axis.Z]\n", "fanuc-0i-m");
  EXPECT_EQ(axes_of(machine), "XYZACW");
  EXPECT_EQ(machine.axis_index('A'), 3u);
  EXPECT_FALSE(machine.axis_index('B'));
}

TEST(MachineFile, TheArgumentOverridesTheProfileOfTheFile) {
  EXPECT_EQ(parsed("[machine]\nprofile = \"fanuc-0i-t\"\n", "gsk-218t").profile, "gsk-218t");
}

struct BadFile {
  std::string_view toml, place, says;
};

TEST(MachineFile, ErrorsNameFileLineSectionAndKey) {
  const BadFile cases[] = {
      {"[machine]\nprofile = \"fanuc-0i-t\"\nnmae = \"x\"\n", "t.toml:3: [machine]", "nmae is not a key"},
      {"[machine]\nprofile = \"fanuc-31i\"\n", "t.toml:1: [machine]", "fanuc-31i"},
      {"[machine]\nname = \"x\"\n", "t.toml:1: [machine]", "profile is missing"},
      {"", "t.toml:1: [machine]", "profile is missing"},
      {"[machine]\nprofile = 5\n", "t.toml:2: [machine]", "profile must be text"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\nkind = \"press\"\n", "t.toml:3: [machine]", "press"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\nperiod_us = 100\n", "t.toml:3: [machine]",
       "period_us = 100 is out of range"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\nperiod_us = 1000.5\n", "t.toml:3: [machine]", "whole number"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\nname = \"a\\u0007\"\n", "t.toml:3: [machine]", "control"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\nmax_mm = -2000\n", "t.toml:3: [axis.X]",
       "max_mm must be greater"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\nmax_acceleration = 1\n", "t.toml:4: [axis.X]",
       "max_acceleration is not a key"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\nrapid_mm_min = 0\n", "t.toml:4: [axis.X]",
       "rapid_mm_min = 0"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\nrapid_mm_min = nan\n", "t.toml:4: [axis.X]",
       "rapid_mm_min"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\nrapid_mm_min = inf\n", "t.toml:4: [axis.X]",
       "rapid_mm_min"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\nrapid_mm_min = \"9\"\n", "t.toml:4: [axis.X]",
       "must be a number"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\nmin_mm = 1\n", "t.toml:3: [axis.X]", "reference_mm"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\nbacklash_um = -1\n", "t.toml:4: [axis.X]",
       "backlash_um"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\npitch_error = [[0, 0], [0, 1]]\n",
       "t.toml:4: [axis.X]", "ascend"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.X]\npitch_error = [1, 2]\n", "t.toml:4: [axis.X]",
       "pairs"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.Q]\n", "t.toml:3: [axis.Q]", "not an axis"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axis.W]\n", "t.toml:3: [axis.W]", "incremental word of Z"},
      {"[machine]\nprofile = \"fanuc-0i-m\"\n[axis]\nX = 3\n", "t.toml:4: [axis.X]", "must be a table"},
      {"[machine]\nprofile = \"fanuc-0i-m\"\n[axis.A]\ndesignation = \"diameter\"\n", "t.toml:3: [axis.A]",
       "rotary axis"},
      {"[machine]\nprofile = \"fanuc-0i-m\"\n[axis.A]\n[axis.B]\n[axis.C]\n[axis.U]\n[axis.V]\n[axis.W]\n",
       "t.toml:", "9 axes"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[spindle]\nmin_rpm = 5000\n", "t.toml:3: [spindle]", "min_rpm"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[drive]\ntype = \"ethercat\"\n", "t.toml:4: [drive]",
       "ethercat"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[path]\ntolerance_mm = 0\n", "t.toml:4: [path]", "tolerance_mm"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[path]\ntolerance_deg = 0\n", "t.toml:4: [path]", "tolerance_deg"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[memory]\nprograms_kb = 0\n", "t.toml:4: [memory]",
       "programs_kb"},
      {"[machine]\nprofile = \"fanuc-0i-t\"\n[axes.X]\n", "t.toml:", "not a section"},
      {"[machine]\nprofile = \"fanuc-0i-t\n", "t.toml:2:", ""},
      {"[machine]\nprofile = \"fanuc-0i-t\"\nprofile = \"gsk-218t\"\n", "t.toml:3:", ""},
  };
  for (const auto& bad : cases) {
    EXPECT_THAT(refusal(bad.toml), StartsWith(std::string(bad.place))) << bad.toml;
    EXPECT_THAT(refusal(bad.toml), HasSubstr(std::string(bad.says))) << bad.toml;
  }
}

TEST(MachineFile, AMissingFileIsAnErrorWithItsName) {
  const auto result = load_machine("/nonexistent/lathe.toml");
  ASSERT_TRUE(std::holds_alternative<MachineError>(result));
  EXPECT_THAT(std::get<MachineError>(result).message, HasSubstr("/nonexistent/lathe.toml"));
}

TEST(MachineFile, WrittenAndReadAgainIsTheSame) {
  auto machine =
      parsed("[axis.A]\nmin_mm = -0.1\n[axis.X]\npitch_error = [[-1.25, 0.3], [0.1, 7]]\n", "fanuc-0i-m");
  machine.name = "a \"quoted\" \\ 名";
  machine.tolerance_mm = 1.0 / 3;
  machine.tolerance_deg = 2.0 / 3;
  machine.axes[1].rapid_mm_min = 12'345.678'9;
  const std::string once = to_toml(machine);
  const auto again = parsed(once);
  EXPECT_EQ(to_toml(again), once);
  EXPECT_EQ(again.name, machine.name);
  EXPECT_EQ(again.tolerance_mm, machine.tolerance_mm);
  EXPECT_EQ(again.tolerance_deg, machine.tolerance_deg);
  EXPECT_EQ(parsed("[path]\ntolerance_mm = 0.003\n", "fanuc-0i-m").tolerance_deg, 0.003) << "the number of mm";
  EXPECT_EQ(again.axes[1].rapid_mm_min, 12'345.678'9);
  ASSERT_EQ(again.axes[0].pitch_error.size(), 2u);
  EXPECT_EQ(again.axes[0].pitch_error[1].error_um, 7);
}

TEST(MachineFile, WhatAxesAndSpindleAreBuiltLikeIsReadAndWritten) {
  const Machine machine = parsed(
      "[machine]\nprofile = \"fanuc-0i-m\"\nskip_input = true\ninterruption_input = true\nsecond_auxiliary = true\npolygon_axis = "
      "\"A\"\n"
      "[axis.X]\nhoming = \"dog\"\ndog_mm = 80\ndog_width_mm = 12\ngrid_mm = 6\nhome_negative = true\n"
      "creep_mm_min = 200\nemergency_deceleration_mm_s2 = 5000\npitch_error_negative = [[0, 1], [10, 2]]\n"
      "[axis.Y]\nfollowing_error_mm = 3\nfollowing_error_stopped_mm = 0.2\nin_position_um = 5\n"
      "inclined_deg = 30\ninclined_to = \"Z\"\ngear_numerator = 3\ngear_denominator = 7\n"
      "[axis.V]\nfollows = \"X\"\nsynchronous_error_mm = 0.05\n"
      "[axis.A]\nplc = true\n[axis.C]\nencoder_um = 1\nfriction_mm_s2 = 40\ninertia_ratio = 2\n"
      "[spindle]\ntap_rpm = 2000\norient_m = 18\norient_deg = 45\ncontour_axis = \"C\"\ncontour_on_m = 81\n"
      "contour_off_m = 82\n[drive]\ntype = \"ideal\"\n");
  EXPECT_TRUE(machine.skip_input);
  EXPECT_TRUE(machine.interruption_input);
  EXPECT_TRUE(machine.second_auxiliary);
  EXPECT_EQ(machine.polygon_axis, 'A');
  EXPECT_EQ(machine.drive, "ideal");
  const Axis& x = machine.axes[*machine.axis_index('X')];
  EXPECT_EQ(x.homing, Homing::dog);
  EXPECT_TRUE(x.home_negative);
  EXPECT_EQ(x.pitch_error_negative.size(), 2u);
  EXPECT_EQ(machine.axes[*machine.axis_index('Y')].inclined_to, 'Z');
  EXPECT_EQ(machine.axes[*machine.axis_index('V')].follows, 'X');
  EXPECT_TRUE(machine.axes[*machine.axis_index('A')].plc);
  EXPECT_EQ(machine.spindle.contour_axis, 'C');
  EXPECT_EQ(machine.spindle.orient_m, 18);
  const std::string written = to_toml(machine);
  EXPECT_EQ(to_toml(parsed(written)), written);
}

TEST(MachineFile, CouplingsNameAxesThatAreThere) {
  for (const char* wrong :
       {"[machine]\nprofile = \"fanuc-0i-m\"\n[axis.V]\nfollows = \"W\"\n",
        "[machine]\nprofile = \"fanuc-0i-m\"\n[axis.X]\nfollows = \"X\"\n",
        "[machine]\nprofile = \"fanuc-0i-m\"\n[axis.X]\nfollows = \"Y\"\n[axis.Y]\nfollows = \"Z\"\n",
        "[machine]\nprofile = \"fanuc-0i-m\"\n[axis.Y]\ninclined_deg = 10\n",
        "[machine]\nprofile = \"fanuc-0i-m\"\npolygon_axis = \"X\"\n",
        "[machine]\nprofile = \"fanuc-0i-m\"\n[spindle]\ncontour_axis = \"C\"\n"}) {
    EXPECT_TRUE(std::holds_alternative<MachineError>(parse_machine(wrong, "m.toml"))) << wrong;
  }
}

TEST(MachineFile, TheDefaultsOfEveryProfileAreAValidFile) {
  for (const std::string_view profile :
       {"fanuc-0i-t", "fanuc-0i-m", "gsk-2000tc", "gsk-218t", "k2000tc", "lathe-200t"}) {
    const std::string written = to_toml(*default_machine(profile));
    EXPECT_EQ(to_toml(parsed(written)), written);
  }
}

TEST(MachineFile, TheMachinesOfTheQuickstartAreValid) {
  struct Shipped {
    std::string_view file, profile, axes;
  };
  const Shipped shipped[] = {
      {"lathe-1", "fanuc-0i-t", "XZ"}, {"mill-1", "fanuc-0i-m", "XYZ"}, {"lathe-2", "gsk-2000tc", "XZ"}};
  for (const auto& [file, profile, axes] : shipped) {
    const auto result =
        load_machine(std::string(HEADSTOCK_SOURCE_DIR "/deploy/machines/") + std::string(file) + ".toml");
    ASSERT_TRUE(std::holds_alternative<Machine>(result)) << std::get<MachineError>(result).message;
    EXPECT_EQ(std::get<Machine>(result).name, file);
    EXPECT_EQ(std::get<Machine>(result).profile, profile);
    EXPECT_EQ(axes_of(std::get<Machine>(result)), axes);
  }
}

}  // namespace
}  // namespace headstock::machine
