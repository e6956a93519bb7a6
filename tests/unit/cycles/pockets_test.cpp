// Pockets inside pockets: which cuts G71 type II makes, and in which order. The reference reads the profile
// as a plain polygon and asks for every level where it lies below; the planner's stretches, places and
// coroutines are not in it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "../compensation/contour.hpp"
#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"

namespace headstock::reference {
namespace {

struct Level {
  double x, from, to;  // radius, Z where the cut begins and ends
};

// Where the polygon is below `x`, between two places along Z, in the order of the cuts (toward −Z).
std::vector<Level> below(const std::vector<Xy>& polygon, double x, double from, double to) {
  std::vector<double> places;
  for (std::size_t i = 0; i + 1 < polygon.size(); ++i) {
    const Xy a = polygon[i], b = polygon[i + 1];
    if ((a.y < x) == (b.y < x)) continue;
    const double at = a.x + (b.x - a.x) * (x - a.y) / (b.y - a.y);
    if (at <= from + 1e-9 && at >= to - 1e-9) places.push_back(at);
  }
  std::sort(places.begin(), places.end(), std::greater<>());
  std::vector<Level> found;
  for (std::size_t i = 0; i + 1 < places.size(); i += 2) found.push_back({x, places[i], places[i + 1]});
  return found;
}

// Each pocket is finished before the next one begins.
void walk(const std::vector<Xy>& polygon, double top, double depth, int k, double from, double to,
          std::vector<Level>& cuts) {
  for (const Level& level : below(polygon, top - depth * k, from, to)) {
    cuts.push_back(level);
    walk(polygon, top, depth, k + 1, level.from, level.to, cuts);
  }
}

std::vector<Level> level_cuts(const std::string& program, double start_x, double start_z, double top,
                              double depth, std::string& alarm) {
  const machine::Machine machine = *machine::default_machine("fanuc-0i-t");
  interp::MachineData data;
  data.parameters["5105#2"] = 1;  // no contour pass
  interp::Interpreter interpreter(*dialects::find("fanuc-0i-t"), machine, data, nullptr);
  interpreter.start(program::source_from_text(program), {start_x, start_z});
  std::vector<Level> cuts;
  double x = start_x, z = start_z;
  interp::Operation op;
  while (interpreter.next(op) == interp::Pull::operation) {
    if (const auto* refused = std::get_if<interp::Alarm>(&op)) alarm = refused->code;
    const interp::Motion* motion = nullptr;
    if (const auto* rapid = std::get_if<interp::Rapid>(&op)) motion = rapid;
    const auto* feed = std::get_if<interp::Feed>(&op);
    if (feed != nullptr) motion = feed;
    if (motion == nullptr) continue;
    const double to_x = motion->end_machine[0], to_z = motion->end_machine[1];
    const double levels = (top - to_x) / depth;
    const bool on_level = std::fabs(levels - std::round(levels)) < 1e-6 && levels > 0.5;
    if (feed != nullptr && std::fabs(to_x - x) < 1e-9 && on_level && z - to_z > 1e-6)
      cuts.push_back({x, z, to_z});
    x = to_x;
    z = to_z;
  }
  return cuts;
}

std::string program_of(const std::vector<Xy>& polygon, double depth) {
  char text[100];
  std::snprintf(text, sizeof text, "O1\nG98\nG71 U%.3f R0.2\nG71 P1 Q2 U0 W0 F100\n", depth);
  std::string program = text;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const char* const head = i == 0 ? "N1 G00 " : i + 1 == polygon.size() ? "N2 G01 " : "G01 ";
    std::snprintf(text, sizeof text, "%sX%.3f Z%.3f\n", head, 2 * polygon[i].y, polygon[i].x);
    program += text;
  }
  return program + "M30\n";
}

void compare(const std::vector<Xy>& polygon, double start_x, double start_z, double depth) {
  const std::string program = program_of(polygon, depth);
  SCOPED_TRACE(program);
  std::vector<Level> expected;
  walk(polygon, start_x, depth, 1, 1e9, -1e9, expected);
  std::string alarm;
  const std::vector<Level> made = level_cuts(program, start_x, start_z, start_x, depth, alarm);
  ASSERT_EQ(alarm, "");
  ASSERT_EQ(made.size(), expected.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    SCOPED_TRACE(i);
    ASSERT_NEAR(made[i].x, expected[i].x, 1e-6);
    ASSERT_NEAR(made[i].from, expected[i].from, 1.1e-3);  // crossings are rounded to the least increment
    ASSERT_NEAR(made[i].to, expected[i].to, 1.1e-3);
  }
}

// The profile of the case known_pocket_in_pocket.
TEST(Pockets, KnownPocketInAPocket) {
  compare({{0, 20}, {-5, 20}, {-5, 16}, {-10, 16}, {-10, 14}, {-15, 14}, {-15, 16}, {-25, 20}}, 21, 2, 2);
}

TEST(Pockets, RandomPocketsInTheOrderOfTheReference) {
  std::mt19937 random(77);
  const auto micron = [&](double low, double high) {
    return std::round(std::uniform_real_distribution<double>(low, high)(random) * 1000) / 1000;
  };
  std::size_t cuts = 0;
  for (int i = 0; i < 1'000; ++i) {
    // Both ends above every level, so that each stretch below one begins and ends on the polygon.
    const double top = 30;
    std::vector<Xy> polygon{{0, top}};
    const int count = 3 + i % 8;
    for (int k = 0; k < count; ++k) {
      // No walls: where a level meets one its cut ends in a point that two stretches share.
      polygon.push_back({polygon.back().x - micron(2, 9), micron(18, 29.5)});
    }
    polygon.push_back({polygon.back().x - micron(2, 9), top});
    const double depth = micron(0.7, 3);
    // A ridge exactly on a level: one cut over it or two beside it are the same.
    const bool touches = std::any_of(polygon.begin() + 1, polygon.end() - 1, [&](Xy p) {
      return std::fabs(std::remainder(top - p.y, depth)) < 1e-6;
    });
    if (touches) continue;
    compare(polygon, top + 0.0, 2, depth);
    if (testing::Test::HasFatalFailure()) return;
    std::vector<Level> expected;
    walk(polygon, top, depth, 1, 1e9, -1e9, expected);
    cuts += expected.size();
  }
  EXPECT_GT(cuts, 10'000u);
}

}  // namespace
}  // namespace headstock::reference
