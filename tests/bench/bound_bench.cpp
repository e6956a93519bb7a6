// The least time of a program's run, from `headstock simulate --trace`: reads the trace, prints a line of
// JSON. bound.py calls it for every program of a folder.
//
//   bench_bound PROGRAM TRACE [LINES]    the program for its feeds; LINES: how many of the lines that lose
//   most to name
//   bench_bound --check                    lines, circles and corners against their closed forms
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <tuple>
#include <vector>

#include "least_time.hpp"

namespace {

using namespace headstock;
using bench::PathStep;

constexpr double kRapid = std::numeric_limits<double>::infinity();
constexpr double kStanding = 2e-9;      // mm in a period: the trace has nine decimals
constexpr double kLongestPause = 0.05;  // s; longer ones are dwells, M codes and tool changes

/// Highest speed along the path of each line [mm/s], from G0-G3, F, G20 and G21.
std::vector<double> feeds_of(const char* file) {
  std::vector<double> feeds{kRapid};
  std::ifstream program(file);
  bool rapid = true;
  double unit = 1, feed = 0;
  for (std::string line; std::getline(program, line);) {
    bool comment = false;
    for (std::size_t i = 0; i < line.size() && line[i] != ';'; ++i) {
      if (line[i] == '(' || line[i] == ')') comment = line[i] == '(';
      const char letter =
          comment ? ' ' : static_cast<char>(std::toupper(static_cast<unsigned char>(line[i])));
      if (letter != 'G' && letter != 'F') continue;
      const double value = std::strtod(line.c_str() + i + 1, nullptr);
      if (letter == 'F')
        feed = value * unit / 60;
      else if (value == 20 || value == 21)
        unit = value == 20 ? 25.4 : 1;
      else if (value == 0 || value == 1 || value == 2 || value == 3)
        rapid = value == 0;
    }
    feeds.push_back(rapid || feed <= 0 ? kRapid : feed);
  }
  return feeds;
}

class Run {
 public:
  Run(std::vector<double> feeds, bench::PathLimits limits) : feeds_(std::move(feeds)), limits_(limits) {}

  void sample(double t, int line, const std::array<double, bench::kPathAxes>& at) {
    if (samples_++ == 0) {
      // The first row is one period after the start.
      period_s_ = t;
      last_ = at;
      return;
    }
    PathStep step;
    double longest = 0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      step.way[i] = at[i] - last_[i];
      longest = std::max(longest, std::abs(step.way[i]));
    }
    last_ = at;
    if (longest <= kStanding) {
      if (!stretch_.empty()) finish_stretch();
      ++pause_;
      return;
    }
    if (pause_ > 0) {
      const double pause = static_cast<double>(pause_) * period_s_;
      (pause <= kLongestPause && stretches > 0 ? pauses : waits) += pause;
      pause_ = 0;
    }
    step.line = line;
    step.feed = line >= 0 && static_cast<std::size_t>(line) < feeds_.size()
                    ? feeds_[static_cast<std::size_t>(line)]
                    : kRapid;
    stretch_.push_back(step);
  }
  void finish_stretch() {
    ++stretches;
    moving += static_cast<double>(stretch_.size()) * period_s_;
    bound += bench::least_time(stretch_, period_s_, limits_);
    for (const PathStep& step : stretch_) lost[step.line] += period_s_ * (1 - 1 / step.speed_up);
    stretch_.clear();
  }

  long stretches = 0;
  double moving = 0, pauses = 0, waits = 0, bound = 0;
  std::map<int, double> lost;  // seconds a line

 private:
  std::vector<double> feeds_;
  bench::PathLimits limits_;
  std::vector<PathStep> stretch_;
  std::array<double, bench::kPathAxes> last_{};
  double period_s_ = 0;
  long samples_ = 0, pause_ = 0;
};

int measure(const char* program, const char* trace, std::size_t lines) {
  std::FILE* in = std::fopen(trace, "r");
  if (!in) return std::cerr << "bench_bound: " << trace << ": cannot be read\n", 1;
  Run run(feeds_of(program), {});
  char row[512];
  const char* const header = "t,line,X,Y,Z,";
  if (!std::fgets(row, sizeof row, in) || std::strncmp(row, header, std::strlen(header)) != 0)
    return std::cerr << "bench_bound: the trace does not begin with " << header << '\n', 1;
  while (std::fgets(row, sizeof row, in)) {
    std::array<double, 2 + bench::kPathAxes> values{};
    const char* at = row;
    for (double& value : values) {
      const auto read = std::from_chars(at, row + std::strlen(at) + (at - row), value);
      if (read.ec != std::errc{}) return std::cerr << "bench_bound: not a row: " << row, 1;
      at = read.ptr + 1;
    }
    run.sample(values[0], static_cast<int>(values[1]), {values[2], values[3], values[4]});
  }
  std::fclose(in);
  run.finish_stretch();
  std::printf(
      R"({"ours_s": %.3f, "bound_s": %.3f, "moving_s": %.3f, "pauses_s": %.3f, "waits_s": %.3f, "stretches": %ld, "lost_ms": {)",
      run.moving + run.pauses, run.bound, run.moving, run.pauses, run.waits, run.stretches);
  std::vector<std::pair<int, double>> worst(run.lost.begin(), run.lost.end());
  std::sort(worst.begin(), worst.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  if (worst.size() > lines) worst.resize(lines);
  for (std::size_t i = 0; i < worst.size(); ++i)
    std::printf("%s\"%d\": %.1f", i ? ", " : "", worst[i].first, worst[i].second * 1000);
  std::printf("}}\n");
  return 0;
}

constexpr int kCheckSteps = 20'000;
constexpr double kSlower = 4;
/// What a rest may cost a run so much slower than it could be: the sample before it.
constexpr double kOneSample = 1.1 * kSlower / kCheckSteps;

/// Least time of a run of `kCheckSteps` samples that takes kSlower times `expected`, at a speed that changes
/// much.
/// @param at the place at a share of the way, 0 … 1
template <typename At>
double least_time_of(double expected, double feed, At at) {
  constexpr int steps = kCheckSteps;
  const auto place = [&](int i) {
    const double u = static_cast<double>(i) / steps, even = (1 - std::cos(std::numbers::pi * u)) / 2;
    return at(even + 0.02 * std::sin(20 * std::numbers::pi * u) * even * (1 - even));
  };
  std::vector<PathStep> path(steps);
  for (int i = 0; i < steps; ++i) {
    PathStep& step = path[static_cast<std::size_t>(i)];
    const auto from = place(i), to = place(i + 1);
    for (std::size_t k = 0; k < bench::kPathAxes; ++k) step.way[k] = to[k] - from[k];
    step.feed = feed;
  }
  return bench::least_time(path, kSlower * expected / steps, {});
}

/// Time from rest to rest at this speed and acceleration.
double trapezoid(double way, double speed, double acceleration) {
  return way >= speed * speed / acceleration ? way / speed + speed / acceleration
                                             : 2 * std::sqrt(way / acceleration);
}

/// Square corners after each other, along X and Y by turns, each a parabola in which one axis brakes and the
/// other speeds up with all it has. Faster than that no point of a corner can be passed: the whole has a
/// closed form.
struct Staircase {
  double leg, straight,
      acceleration;  // from a parabola's end to the corner; between two parabolas [mm], mm/s²
  int corners;

  double corner_s() const { return std::sqrt(2 * leg / acceleration); }
  double straight_s() const {
    return 2 * (std::sqrt(2 * leg / acceleration + straight / acceleration) - corner_s());
  }
  /// From rest to rest, with as long a run-up and run-out as a corner's leg.
  double least_time() const { return (corners + 2) * corner_s() + (corners - 1) * straight_s(); }
  /// Where the fastest run is after this time: each axis speeds up and brakes evenly, the next one begins as
  /// it brakes.
  std::array<double, bench::kPathAxes> at(double t) const {
    std::array<double, bench::kPathAxes> place{};
    double begin = 0;
    for (int k = 0; k <= corners && t > begin; ++k) {
      // The first straight begins at rest, the last one ends there: only a leg and its mirror image.
      const bool edge = k == 0 || k == corners;
      const double half = edge ? corner_s() : corner_s() + straight_s() / 2,
                   u = std::min(t - begin, 2 * half);
      const double left = 2 * half - u;
      place[static_cast<std::size_t>(k % 2)] +=
          acceleration * (u < half ? u * u / 2 : half * half - left * left / 2);
      begin += 2 * half - corner_s();
    }
    return place;
  }
};

int check() {
  using Place = std::array<double, bench::kPathAxes>;
  int wrong = 0;
  const auto judge = [&](const char* what, double found, double least, double most) {
    const bool good = found >= least && found <= most;
    wrong += !good;
    std::printf("%-45s %9.5f s, closed form %9.5f … %9.5f s%s\n", what, found, least, most,
                good ? "" : "  WRONG");
  };
  const auto line = [&](const char* what, double feed, Place way, double expected) {
    const double found = least_time_of(expected, feed, [&](double share) {
      return Place{share * way[0], share * way[1], share * way[2]};
    });
    judge(what, found, expected * 0.9999, expected * (1.0001 + kOneSample));
  };
  line("100 mm along X, F6000", 100, {100, 0, 0}, trapezoid(100, 100, 2000));
  line("20 mm along X, rapid: a triangle", kRapid, {20, 0, 0}, trapezoid(20, 500, 2000));
  line("500 mm at an angle, rapid: what Y can do", kRapid, {300, 400, 0}, trapezoid(400, 500, 2000));

  const double radius = 10, way = 2 * std::numbers::pi * radius * 20;
  const auto circles = [&](double share) {
    return Place{radius * std::cos(share * way / radius), radius * std::sin(share * way / radius), 0};
  };
  // Feed far below what the radius allows; only the ramps' acceleration is between that of one axis and of
  // two.
  const double calm = way / 50;
  judge("20 circles of radius 10 mm, F3000", least_time_of(calm, 50, circles),
        calm + 50 / (2000 * std::numbers::sqrt2), (calm + 50.0 / 2000) * (1.0001 + kOneSample));
  // v² / r = 2,000 wherever the circle crosses an axis, at most √2 of that between.
  const double even = way / std::sqrt(2000 * radius);
  judge("20 circles of radius 10 mm, rapid", least_time_of(even, kRapid, circles),
        even / std::sqrt(std::numbers::sqrt2), even);

  // Here the samples are those of the fastest run itself. What is found is less by as much as they make a
  // corner rounder.
  const Staircase stairs{0.03, 0.24, 2000, 400};
  for (const auto& [what, period_s, share] :
       {std::tuple{"400 corners at 0.3 mm, a sample in 1 ms", 1e-3, 0.999},
        {"400 corners at 0.3 mm, a sample in 0.25 ms", 0.25e-3, 0.9995}}) {
    std::vector<PathStep> path(static_cast<std::size_t>(std::ceil(stairs.least_time() / period_s)));
    for (std::size_t k = 0; k < path.size(); ++k) {
      const auto from = stairs.at(static_cast<double>(k) * period_s),
                 to = stairs.at(static_cast<double>(k + 1) * period_s);
      for (std::size_t i = 0; i < bench::kPathAxes; ++i) path[k].way[i] = to[i] - from[i];
      path[k].feed = kRapid;
    }
    judge(what, bench::least_time(path, period_s, {}), share * stairs.least_time(),
          stairs.least_time() + period_s);
  }
  return wrong ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--check") == 0) return check();
  if (argc < 3) return std::cerr << "usage: bench_bound PROGRAM TRACE [LINES] | --check\n", 2;
  return measure(argv[1], argv[2], argc > 3 ? static_cast<std::size_t>(std::atoi(argv[3])) : 0);
}
