// Inner corners under G62 (0i-D 5.4.2.1): where the feed is reduced, where not, and what is refused.
#include "operation/corner_override.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bench.hpp"
#include "operation/path_length.hpp"

namespace headstock::operation {
namespace {

constexpr CuttingSide kLeft{1, 0, 1}, kRight{-1, 0, 1};
constexpr double kCornerFeed = 50;

struct CornerPiece {
  double length, feed;
  AxisVector end;
  bool block_end;
};

class Corners {
 public:
  explicit Corners(double widest_deg = 120, double ratio = 0.5, double before = 3, double after = 2)
      : stage_(2, [this](const AxisVector& start, const motion::Move& move) {
          EXPECT_EQ(start, last_) << "in order, nothing left out";
          last_ = end_of(move);
          pieces.push_back(
              {path_length(start, move), std::get<motion::PathFeed>(move.feed).mm_s, last_, move.block_end});
        }) {
    stage_.set_rules({ratio, widest_deg * M_PI / 180, before, after, true});
  }
  void line(double x, double y, const CuttingSide& side) {
    motion::Move move;
    move.geometry = motion::Line{{x, y}};
    add(move, {x, y}, side);
  }
  /// About (x0, y0) by this angle.
  void arc(double x0, double y0, double angle, const CuttingSide& side) {
    const double x = at_[0] - x0, y = at_[1] - y0;
    const AxisVector end{x0 + x * std::cos(angle) - y * std::sin(angle),
                         y0 + x * std::sin(angle) + y * std::cos(angle)};
    motion::Move move;
    move.geometry = motion::Arc{end, 0, 1, x0, y0, angle};
    add(move, end, side);
  }
  void end() { stage_.release(); }
  /// Length run at the reduced feed.
  double slowed() const {
    double sum = 0;
    for (const CornerPiece& piece : pieces)
      if (piece.feed < kCornerFeed) sum += piece.length;
    return sum;
  }
  std::vector<CornerPiece> pieces;

 private:
  void add(motion::Move& move, const AxisVector& end, const CuttingSide& side) {
    move.feed = motion::PathFeed{kCornerFeed};
    stage_.add(at_, move, side);
    at_ = end;
  }
  CornerOverride stage_;
  AxisVector at_{}, last_{};
};

TEST(CornerOverride, TheFeedIsReducedFromBeforeAnInnerCornerToBehindIt) {
  Corners corners;
  corners.line(10, 0, kLeft);  // start-up
  corners.line(30, 0, kLeft);
  corners.line(30, 20, kLeft);  // turns left, the tool is left: inside
  corners.line(30, 40, kLeft);
  corners.end();
  ASSERT_EQ(corners.pieces.size(), 6u);
  const double feeds[] = {50, 50, 25, 25, 50, 50};
  const AxisVector ends[] = {{10, 0}, {27, 0}, {30, 0}, {30, 2}, {30, 20}, {30, 40}};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_DOUBLE_EQ(corners.pieces[i].feed, feeds[i]) << i;
    EXPECT_NEAR(corners.pieces[i].end[0], ends[i][0], 1e-6) << i;
    EXPECT_NEAR(corners.pieces[i].end[1], ends[i][1], 1e-6) << i;
    EXPECT_EQ(corners.pieces[i].block_end, i != 1 && i != 3) << i;
  }
}

TEST(CornerOverride, OutsideCornersAndWideOnesKeepTheFeed) {
  for (const bool outside : {true, false}) {
    Corners corners(outside ? 120 : 80);
    const CuttingSide side = outside ? kRight : kLeft;
    corners.line(10, 0, side);
    corners.line(30, 0, side);
    corners.line(30, 20, side);
    corners.end();
    EXPECT_EQ(corners.pieces.size(), 3u);
    EXPECT_EQ(corners.slowed(), 0) << outside;
  }
}

TEST(CornerOverride, ReachesOverSeveralShortBlocksAndOverlapsOnce) {
  Corners corners(120, 0.5, 3, 2);
  corners.line(10, 0, kLeft);
  for (int i = 1; i <= 20; ++i) corners.line(10 + i, 0, kLeft);
  corners.line(30, 1, kLeft);  // two inner corners 1 mm apart
  for (int i = 1; i <= 20; ++i) corners.line(30 - i, 1, kLeft);
  corners.end();
  EXPECT_NEAR(corners.slowed(), 3 + 1 + 2, 0.2);  // straight distances: a little longer on the far sides
  for (const CornerPiece& piece : corners.pieces) EXPECT_GE(piece.feed, 0.5 * kCornerFeed) << "not twice";
}

TEST(CornerOverride, NotAtTheStartUpNorWhereTheSideChanges) {
  Corners corners;
  corners.line(10, 0, CuttingSide{});
  corners.line(30, 0, kLeft);  // start-up
  corners.line(30, 20, kLeft);
  corners.line(10, 20, kRight);
  corners.end();
  EXPECT_EQ(corners.slowed(), 0);
}

TEST(CornerOverride, DistancesOnArcsAreStraight) {
  Corners corners(170, 0.5, 3, 3);
  corners.line(0, -10, kRight);
  corners.line(-10, -10, kRight);
  corners.line(10, -10, kRight);
  // Leaves (10, -10) upward, turning right: a corner of 90° with the line is left of it.
  corners.end();
  EXPECT_EQ(corners.slowed(), 0) << "straight back is no corner";
  Corners round(170, 0.5, 3, 3);
  round.line(10, 0, kLeft);
  round.line(30, 0, kLeft);
  round.arc(20, 0, M_PI / 2, kLeft);  // from (30, 0) to (20, 10): leaves upward, 90° to the left
  round.end();
  const double on_arc = 2 * 10 * std::asin(3.0 / 20);
  EXPECT_NEAR(round.slowed(), 3 + on_arc, 1e-6);
}

TEST(CornerOverride, ArcsIntoTheOppositeQuadrantKeepTheFeed) {
  Corners corners(170, 0.5, 3, 3);
  corners.line(10, 0, kLeft);
  corners.line(30, 0, kLeft);
  corners.arc(20, 0, 1.2 * M_PI, kLeft);
  corners.end();
  EXPECT_NEAR(corners.slowed(), 3, 1e-6) << "the line's part only";
}

// ---- with the whole controller

const std::string kPocket =
    "O1\nG90 G94 G21 G17\nG62\nG01 G41 X10. Y0. D1 F3000.\nX40.\nY30.\nX80.\nG40 Y60.\nG64\nM30\n";

struct CornerSpeeds {
  double at_corner = 0, before = 0;  ///< path speed near the inner corner and well before it
  State end = State::idle;
  std::string alarm;
};

CornerSpeeds run_pocket(const std::map<std::string, double, std::less<>>& parameters,
                        const std::string& program) {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  for (machine::Axis& axis : machine.axes) {
    axis.max_feed_mm_min = axis.rapid_mm_min = 30'000;
    axis.max_acceleration_mm_s2 = 5'000;
    axis.max_jerk_mm_s3 = 1e12;
  }
  Bench bench(machine);
  EXPECT_TRUE(bench.controller
                  .edit_data(
                      [&](interp::MachineData& data) {
                        data.parameters.insert(parameters.begin(), parameters.end());
                        data.tools.resize(2);
                        data.tools[1].radius = 1;
                      },
                      {}, "test")
                  .accepted);
  bench.load(program);
  EXPECT_TRUE(bench.start());
  CornerSpeeds speeds;
  bench.until(
      [&] {
        const motion::Sample& sample = bench.controller.sample();
        // On the way along X before the corner at X40.
        if (sample.position[0] > 33 && sample.position[0] < 36 && sample.position[1] < 2)
          speeds.at_corner = std::max(speeds.at_corner, sample.path_speed_mm_s);
        if (sample.position[0] > 15 && sample.position[0] < 25 && sample.position[1] < 2)
          speeds.before = std::max(speeds.before, sample.path_speed_mm_s);
        return bench.periods > 10 && bench.state() != State::running;
      },
      60);
  speeds.end = bench.state();
  if (!bench.controller.live().alarms.empty()) speeds.alarm = bench.controller.live().alarms[0].code;
  return speeds;
}

const std::map<std::string, double, std::less<>> kSet = {
    {"1711", 120}, {"1712", 40}, {"1713", 10}, {"1714", 5}};

TEST(CornerOverride, InAProgram) {
  const CornerSpeeds speeds = run_pocket(kSet, kPocket);
  EXPECT_EQ(speeds.end, State::idle) << speeds.alarm;
  EXPECT_NEAR(speeds.before, 50, 0.1);
  EXPECT_NEAR(speeds.at_corner, 20, 0.1);
}

TEST(CornerOverride, NotWithoutG62NorWithoutCompensationNorUnderLookAhead) {
  std::string plain = kPocket;
  plain.erase(plain.find("G62\n"), 4);
  EXPECT_NEAR(run_pocket(kSet, plain).at_corner, 50, 0.1);
  std::string bare = kPocket;
  bare.erase(bare.find("G41 "), 4);
  EXPECT_NEAR(run_pocket(kSet, bare).at_corner, 50, 0.1);
  std::string ahead = kPocket;
  ahead.insert(ahead.find("G62\n"), "G05.1 Q1\n");
  ahead.insert(ahead.find("M30"), "G05.1 Q0\n");
  EXPECT_NEAR(run_pocket(kSet, ahead).at_corner, 50, 0.1);
}

TEST(CornerOverride, ParametersOutOfRangeAreAnAlarmBeforeMotion) {
  EXPECT_EQ(run_pocket({}, kPocket).alarm, "PS0148");
  auto wrong = kSet;
  wrong["1711"] = 179;
  EXPECT_EQ(run_pocket(wrong, kPocket).alarm, "PS0148");
}

// Programmed radius 4 mm, tool 1 mm inside it: its centre runs on 3 mm.
TEST(InnerArc, TheFeedHoldsOnTheProgrammedArcDownToItsLeast) {
  const std::string inside =
      "O1\nG90 G94 G21 G17\nG01 G41 X20. Y-4. D1 F600.\nX34.\nG03 Y4. I0. J4.\nG01 X20.\nG40 Y20.\nM30\n";
  const auto on_arc = [&](double least) {
    Bench bench("fanuc-0i-m");
    EXPECT_TRUE(bench.controller
                    .edit_data(
                        [&](interp::MachineData& data) {
                          data.parameters["1710"] = least;
                          data.tools.resize(2);
                          data.tools[1].radius = 1;
                        },
                        {}, "test")
                    .accepted);
    bench.load(inside);
    EXPECT_TRUE(bench.start());
    EXPECT_TRUE(bench.until([&] { return bench.controller.sample().position[0] > 36.9; }, 60));
    return bench.controller.sample().path_speed_mm_s;
  };
  EXPECT_NEAR(on_arc(0), 10, 0.01) << "off";
  EXPECT_NEAR(on_arc(20), 7.5, 0.01) << "3/4 of it";
  EXPECT_NEAR(on_arc(90), 9, 0.01) << "not below 90 %";
}

}  // namespace
}  // namespace headstock::operation
