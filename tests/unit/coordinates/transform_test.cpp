// Mirror, scaling and rotation against plain matrices, with random figures.
#include "interpreter/transform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/unit/coordinates/bench.hpp"

namespace headstock::interp {
namespace {

TEST(Transform, UndoTakesEveryPositionBack) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-500, 500), factor(0.1, 4);
  for (int i = 0; i < 2'000; ++i) {
    Transform t;
    t.mirrored = static_cast<std::uint32_t>(random() % 8);
    t.scaled = static_cast<std::uint32_t>(random() % 8);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      t.mirror_at[axis] = any(random);
      t.scale_center[axis] = any(random);
      t.factor[axis] = (random() % 2 == 0 ? 1 : -1) * factor(random);
    }
    t.rotated = random() % 2 == 0;
    t.first = 0;
    t.second = 1;
    t.center_1 = any(random);
    t.center_2 = any(random);
    t.set_angle(any(random));
    const machine::AxisVector p{any(random), any(random), any(random)};
    const auto back = t.undo(t.apply(p));
    for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(back[axis], p[axis], 1e-9);
  }
}

TEST(Transform, RightAnglesAreExact) {
  Transform t;
  t.rotated = true;
  t.first = 0;
  t.second = 1;
  const double cosines[] = {1, 0, -1, 0, 1}, sines[] = {0, 1, 0, -1, 0};
  for (int quarter = -8; quarter <= 8; ++quarter) {
    t.set_angle(90.0 * quarter);
    const auto k = static_cast<std::size_t>((quarter % 4 + 4) % 4);
    EXPECT_EQ(t.cosine, cosines[k]) << quarter;
    EXPECT_EQ(t.sine, sines[k]) << quarter;
  }
}

// A figure of lines and arcs under G51.1, G51 and G68 together: every point equals the figure's own point
// carried through the three steps, arcs keep their centre and turn round when the plane is mirrored an odd
// number of times.
TEST(Transform, AFigureIsCarriedAsAWhole) {
  const std::string figure =
      "G90 G01 X20. Y10. F100\nG02 X30. Y0 I0 J-10.\nG03 X40. Y10. R10.\nG91 G01 X5. Y-3.\nG03 X4. Y4. R4.\n";
  const auto moves = [&figure](const std::string& before) {
    Bench bench("fanuc-0i-m");
    std::vector<Operation> out;
    for (const Operation& operation : bench.run("G00 X10. Y10.\n" + before + figure + "M30\n")) {
      EXPECT_FALSE(std::holds_alternative<Alarm>(operation));
      if (std::holds_alternative<Feed>(operation) || std::holds_alternative<Arc>(operation))
        out.push_back(operation);
    }
    return out;
  };
  const auto plain = moves("");
  ASSERT_EQ(plain.size(), 5u);
  struct Setting {
    const char* text;
    bool mirror;
    double scale, angle_deg;
  };
  const Setting settings[] = {{"G68 X3. Y-2. R37.\n", false, 1, 37},
                              {"G51 X3. Y-2. Z0 P150000\n", false, 1.5, 0},
                              {"G51.1 X3.\n", true, 1, 0},
                              {"G51.1 X3.\nG51 X5. Y1. Z0 P150000\nG68 X3. Y-2. R37.\n", true, 1.5, 37}};
  for (const Setting& setting : settings) {
    const auto made = moves(setting.text);
    ASSERT_EQ(made.size(), plain.size()) << setting.text;
    const double cosine = std::cos(setting.angle_deg * std::numbers::pi / 180);
    const double sine = std::sin(setting.angle_deg * std::numbers::pi / 180);
    const auto carried = [&](double x, double y) {
      const bool all = setting.mirror && setting.angle_deg != 0;
      // rotation about its own centre first, then scaling, then the mirror: the same by another order
      if (setting.angle_deg != 0) {
        const double a = x - 3, b = y + 2;
        x = 3 + cosine * a - sine * b;
        y = -2 + sine * a + cosine * b;
      }
      if (setting.scale != 1) {
        const double cx = all ? 5 : 3, cy = all ? 1 : -2;
        x = cx + setting.scale * (x - cx);
        y = cy + setting.scale * (y - cy);
      }
      if (setting.mirror) x = 6 - x;
      return std::pair(x, y);
    };
    for (std::size_t i = 0; i < plain.size(); ++i) {
      const auto [x, y] = carried(motion_of(plain[i])->end_work[0], motion_of(plain[i])->end_work[1]);
      EXPECT_NEAR(motion_of(made[i])->end_work[0], x, 0.0011) << setting.text << i;
      EXPECT_NEAR(motion_of(made[i])->end_work[1], y, 0.0011) << setting.text << i;
      const auto* arc = std::get_if<Arc>(&made[i]);
      const auto* original = std::get_if<Arc>(&plain[i]);
      ASSERT_EQ(arc == nullptr, original == nullptr);
      if (arc == nullptr) continue;
      const auto [cx, cy] = carried(original->center_work[0], original->center_work[1]);
      EXPECT_NEAR(arc->center_work[0], cx, 0.003) << setting.text << i;
      EXPECT_NEAR(arc->center_work[1], cy, 0.003) << setting.text << i;
      EXPECT_NEAR(arc->turns, original->turns, 1e-4);
      EXPECT_EQ(arc->turn == original->turn, !setting.mirror);
    }
  }
}

TEST(Transform, NothingMovesWhenTheModesAreSwitched) {
  Bench bench("fanuc-0i-m");
  const auto made = bench.run(
      "G00 X10. Y20.\nG68 X0 Y0 R45.\nG91 G00 X0\nG90 G69\nG91 X0\nG90\nG51 X1. P300000\nG91 "
      "X0\nG50\nG90\nM30\n");
  for (const Operation& operation : made) {
    if (const Motion* m = motion_of(operation)) {
      EXPECT_NEAR(m->end_machine[0], 10, 1e-6);
      EXPECT_NEAR(m->end_machine[1], 20, 1e-6);
    }
  }
}

}  // namespace
}  // namespace headstock::interp
