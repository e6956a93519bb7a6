// Speeds by the controllers' parameters: arcs, corners, short segments, highest speeds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bench.hpp"

namespace headstock::operation {
namespace {

machine::Machine quick(const std::string& profile) {
  machine::Machine machine = *machine::default_machine(profile);
  for (machine::Axis& axis : machine.axes) {
    axis.max_feed_mm_min = axis.rapid_mm_min = 30'000;
    axis.max_acceleration_mm_s2 = 5'000;
    axis.max_jerk_mm_s3 = 1e12;
  }
  return machine;
}

struct Speeds {
  double highest = 0;  ///< of all periods [mm/s]
  double middle = 0;   ///< half way through
};

Speeds run(const std::string& profile, const std::map<std::string, double, std::less<>>& parameters,
           const std::string& program, double feed_override = 1) {
  interp::MachineData data;
  data.parameters = parameters;
  Controller controller(quick(profile), data, virtual_options());
  controller.select("main", "hash", single_program([program] { return program::source_from_text(program); }));
  controller.command({Action::set_feed_override, Origin::panel, feed_override});
  std::vector<double> speeds;
  VirtualRun virtual_run(controller);
  EXPECT_EQ(virtual_run.run([&] {
    if (controller.sample().moving) speeds.push_back(controller.sample().path_speed_mm_s);
    return true;
  }),
            RunEnd::completed)
      << virtual_run.reason;
  Speeds result;
  if (speeds.empty()) return result;
  result.highest = *std::max_element(speeds.begin(), speeds.end());
  result.middle = speeds[speeds.size() / 2];
  return result;
}

constexpr const char* kMill = "fanuc-0i-m";
// Radius 10, F6000 = 100 mm/s.
const std::string kCircle = "G02 X0. Y0. I10. J0. F6000.\n";
std::string mill(const std::string& blocks, bool look_ahead = true) {
  return "O1\nG90 G94 G21 G17 G64\n" + std::string(look_ahead ? "G05.1 Q1\n" : "") + blocks +
         (look_ahead ? "G05.1 Q0\n" : "") + "M30\n";
}

TEST(ArcSpeed, IsTheRootOfAccelerationTimesRadius) {  // 0i-D L21749: No. 1735
  EXPECT_NEAR(run(kMill, {}, mill(kCircle)).highest, 100, 0.1);
  EXPECT_NEAR(run(kMill, {{"1735/X", 250}, {"1735/Y", 400}}, mill(kCircle)).highest, 50, 0.1);
  EXPECT_NEAR(run(kMill, {{"1735/X", 250}}, mill(kCircle), 1.5).highest, 50, 0.1) << "at every override";
  EXPECT_NEAR(run(kMill, {{"1735/X", 250}}, mill(kCircle, false)).highest, 100, 0.1)
      << "look-ahead control is off";
}

TEST(ArcSpeed, IsNotReducedBelowItsLeast) {  // No. 1732
  EXPECT_NEAR(run(kMill, {{"1735/X", 10}, {"1732", 1'800}}, mill(kCircle)).highest, 30, 0.1);
}

TEST(ArcSpeed, OfThe2000TCHoldsAlways) {  // P331, P332
  const std::string arc = "O1\nG98 G21\nG18 G02 X40. Z0. I10. K0. F6000\nM30\n";
  EXPECT_NEAR(run("gsk-2000tc", {}, arc).highest, 100, 1);
  EXPECT_NEAR(run("gsk-2000tc", {{"P331", 250}}, arc).highest, 50, 0.5);
  EXPECT_NEAR(run("gsk-2000tc", {{"P331", 100}, {"P332", 2'400}}, arc).highest, 40, 0.5);
}

// K2000TC L3955: whether G00 or G01 leads away from a thread, P6484 holds; not for what comes after it.
TEST(RetreatSpeed, OfTheK2000TCIsNotAboveItsLimit) {
  struct WayOut {
    const char* blocks;
    double p6484, expected;  // mm/min; mm/s of the slide, 0: faster than all these limits
  };
  constexpr WayOut kWays[] = {{"G92 U-40. W-30. F2.\n", 0, 0},
                              {"G92 U-40. W-30. F2.\n", 600, 10},
                              {"G32 W-30. F2.\nG00 U40.\n", 0, 0},
                              {"G32 W-30. F2.\nG00 U40.\n", 600, 10},
                              {"G32 W-30. F2.\nG01 U40. F3000\n", 600, 10},
                              {"G32 W-30. F2.\nG01 U40. F300\n", 600, 5}};
  for (const WayOut& one : kWays) {
    SCOPED_TRACE(std::string(one.blocks) + "P6484=" + std::to_string(one.p6484));
    interp::MachineData data;
    data.parameters = {{"P0042", 3}, {"P6484", one.p6484}};
    Controller controller(quick("k2000tc"), data, virtual_options());
    const std::string program = "O1\nG98 G21 G97 S500 M03\n" + std::string(one.blocks) + "G00 W30.\nM30\n";
    controller.select("main", "hash",
                      single_program([program] { return program::source_from_text(program); }));
    double x = 0, away = 0, back = 0;
    VirtualRun virtual_run(controller);
    EXPECT_EQ(virtual_run.run([&] {
      const auto sample = controller.sample();
      double& highest = sample.position[0] > x + 1e-9 ? away : back;
      if (sample.position[0] >= x) highest = std::max(highest, sample.path_speed_mm_s);
      x = sample.position[0];
      return true;
    }),
              RunEnd::completed)
        << virtual_run.reason;
    if (one.expected > 0) {
      EXPECT_NEAR(away, one.expected, 0.03 * one.expected);
    } else {
      EXPECT_GT(away, 50);
    }
    EXPECT_GT(back, 50) << "only the way out";
  }
}

double corner_speed(const std::map<std::string, double, std::less<>>& parameters, const std::string& blocks,
                    double x, double y) {
  interp::MachineData data;
  data.parameters = parameters;
  Controller controller(quick(kMill), data, virtual_options());
  const std::string program = mill(blocks);
  controller.select("main", "hash", single_program([program] { return program::source_from_text(program); }));
  double nearest = 1e9, speed = 0;
  VirtualRun virtual_run(controller);
  virtual_run.run([&] {
    const auto sample = controller.sample();
    const double off = std::hypot(sample.position[0] - x, sample.position[1] - y);
    if (off < nearest && sample.moving) {
      nearest = off;
      speed = sample.path_speed_mm_s;
    }
    return true;
  });
  EXPECT_LT(nearest, 0.05);
  return speed;
}

TEST(CornerSpeed, ChangesNoAxisByMoreThanTheDifference) {  // 0i-D L21599: No. 1783 = 500 mm/min
  const std::map<std::string, double, std::less<>> limits{{"1783/X", 60}, {"1783/Y", 60}};
  auto alike = limits;
  alike["19500#6"] = 1;
  const std::string square = "G01 X20. F3000.\nY20.\n", turned = "G01 X20. Y20. F3000.\nX0. Y40.\n";
  EXPECT_LE(corner_speed(limits, square, 20, 0), 1.0 * 1.01);
  EXPECT_GE(corner_speed(limits, square, 20, 0), 1.0 * 0.9);
  EXPECT_LE(corner_speed(limits, turned, 20, 20), 0.7072 * 1.01) << "X is turned round";
  EXPECT_LE(corner_speed(alike, square, 20, 0), 0.7072 * 1.01) << "the same in every direction";
}

TEST(SegmentSpeed,
     IsThatOfTheCircleTheSegmentsStandFor) {  // 0i-D L21827: radius 10 mm, 1000 mm/s² are 6000 mm/min
  std::string blocks;
  char block[64];
  for (int i = 1; i <= 120; ++i) {
    const double angle = 0.05 * i;
    std::snprintf(block, sizeof block, "G01 X%.5f Y%.5f F12000.\n", 10 * std::sin(angle),
                  10 - 10 * std::cos(angle));
    blocks += block;
  }
  std::map<std::string, double, std::less<>> limits{{"1737/X", 1'000}, {"1737/Y", 1'000}, {"19500#6", 1}};
  // Coordinates are thousandths of a millimetre: the turn of a segment is a few per cent off.
  const Speeds alike = run(kMill, limits, mill(blocks));
  EXPECT_NEAR(alike.middle, 100, 7);
  EXPECT_GT(run(kMill, {}, mill(blocks)).middle, 150);
  limits["1737/X"] = limits["1737/Y"] = 10;
  limits["1738"] = 1'800;
  EXPECT_NEAR(run(kMill, limits, mill(blocks)).middle, 30, 1);
}

TEST(HighestSpeed, IsClampedUnderLookAheadControl) {  // 0i-D L22005
  const std::string line = "G01 X100. Y0. F6000.\n";
  EXPECT_NEAR(run(kMill, {{"8465", 3'000}}, mill(line), 1.5).highest, 50, 0.1);
  EXPECT_NEAR(run(kMill, {{"1432/X", 2'400}}, mill(line)).highest, 40, 0.1);
  EXPECT_NEAR(run(kMill, {{"8465", 3'000}}, mill(line, false)).highest, 100, 0.1);
}

}  // namespace
}  // namespace headstock::operation
