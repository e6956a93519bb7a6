// Interference avoided (0i-D CAV): a block is left out and its neighbours meet. Random contours with short
// steps in them: what passes cuts neither the blocks that are run nor the one left out.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "contour.hpp"

namespace headstock::reference {
namespace {

std::vector<Piece> contour_with_steps(std::mt19937& random) {
  std::uniform_real_distribution<double> heading(-1.4, 1.4), size(8, 20), step(0.2, 2), chance(0, 1);
  std::uniform_int_distribution<int> count(4, 9);
  std::vector<Piece> contour;
  Xy at;
  for (int left = count(random); left > 0; --left) {
    const double angle = heading(random), l = chance(random) < 0.3 ? step(random) : size(random);
    contour.push_back(line(at, {at.x + l * std::cos(angle), at.y + l * std::sin(angle)}));
    at = contour.back().to;
  }
  return contour;
}

TEST(CompensationAvoidance, WhatPassesCutsNothingNearby) {
  std::mt19937 random(77);
  std::uniform_real_distribution<double> tool(0.5, 4);
  int avoided = 0, refused = 0, plain = 0;
  for (int i = 0; i < 3'000; ++i) {
    const std::vector<Piece> contour = as_programmed(contour_with_steps(random));
    const double r = std::round(tool(random) * 1000) / 1000;
    const std::string program = program_around(contour, i % 2 == 0 ? 1 : -1);
    SCOPED_TRACE(program + "r " + std::to_string(r));
    const Made without = run(program, r);
    const Made made = run(program, r, R"({"19607#5": 1})");
    if (without.alarm.empty()) {
      ASSERT_EQ(made.alarm, "");  // where nothing interferes nothing changes
      ASSERT_EQ(made.path.size(), without.path.size());
      ++plain;
      continue;
    }
    if (!made.alarm.empty()) {
      ASSERT_TRUE(made.alarm == "PS0041" || made.alarm == "PS5446" || made.alarm == "PS5447" ||
                  made.alarm == "PS5448")
          << made.alarm;
      ++refused;
      continue;
    }
    ++avoided;
    for (std::size_t m = 0; m < made.path.size(); ++m) {
      const unsigned block_line = made.lines[m];
      if (block_line <= kLinesBefore || block_line > kLinesBefore + contour.size()) continue;
      const int own = static_cast<int>(block_line - kLinesBefore) - 1;
      for (int k = 0; k <= 40; ++k) {
        const Xy at = point(made.path[m], k / 40.0);
        for (int j = std::max(0, own - 2); j < static_cast<int>(contour.size()) && j <= own + 2; ++j)
          ASSERT_GT(distance(at, contour[static_cast<std::size_t>(j)]), r - kTolerance)
              << "piece " << j << " cut by the path of piece " << own;
      }
    }
  }
  std::printf("contours without interference %d, avoided %d, refused %d\n", plain, avoided, refused);
  EXPECT_GT(avoided, 100);
  EXPECT_GT(plain, 300);
}

}  // namespace
}  // namespace headstock::reference
