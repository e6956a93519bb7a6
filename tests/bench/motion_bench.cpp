// The motion kernel: look-ahead in segments a second, cost of a period, and the time of a wavy surface
// against the time-optimal speed along it (velocity and acceleration limits only), integrated here without
// any code of the kernel.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "motion/kernel.hpp"
#include "optimal_time.hpp"

namespace {

using namespace headstock;
using motion::Kernel;
using motion::Move;

constexpr double kFeed = 100, kSpeed = 500, kAcceleration = 2000;

double height(double x, double y) {
  return 2 * std::sin(0.8 * x) * std::cos(0.5 * y);
}

machine::Machine machine_of(std::size_t axes, double jerk) {
  machine::Machine machine;
  for (std::size_t i = 0; i < axes; ++i) {
    machine::Axis axis;
    axis.max_feed_mm_min = axis.rapid_mm_min = kSpeed * 60;
    axis.max_acceleration_mm_s2 = kAcceleration;
    axis.max_jerk_mm_s3 = jerk;
    machine.axes.push_back(axis);
  }
  return machine;
}

enum class Corners { stop, round };

/// 20 passes of 400 segments of 0.1 mm, there and back. Exact stops at the ends of the passes as in the
/// bound, or as a control gets it from a program: rounded to 0.001 mm, and no word of a stop.
std::vector<Move> surface(int passes, double turning = 0, Corners corners = Corners::stop) {
  std::vector<Move> moves;
  for (int pass = 0; pass < passes; ++pass)
    for (int i = 0; i <= 400; ++i) {
      const double x = 0.1 * (pass % 2 ? 400 - i : i), y = 0.5 * pass, exact = height(x, y);
      const double z = corners == Corners::round ? std::round(exact * 1000) / 1000 : exact;
      Move move;
      move.tag = moves.size() + 1;
      move.geometry = motion::Line{{x, y, z, turning * x, -turning * x}};
      move.feed = motion::PathFeed{kFeed};
      move.exact_stop = corners == Corners::stop && (i == 400 || i == 0);
      moves.push_back(move);
    }
  return moves;
}

/// Time of one pass by forward and backward integration over x on a fine grid.
double bound_of_pass(double y) {
  constexpr int n = 40'000;
  constexpr double h = 40.0 / n;
  std::vector<double> limit(n + 1), square(n + 1);  // (dx/dt)²
  const auto slope = [&](double x) { return 1.6 * std::cos(0.8 * x) * std::cos(0.5 * y); };
  const auto bend = [&](double x) { return -1.28 * std::sin(0.8 * x) * std::cos(0.5 * y); };
  // |slope u + bend s| <= A and |u| <= A, with u = d²x/dt², s = (dx/dt)²: the range of u.
  const auto range = [&](double x, double s) {
    double low = -kAcceleration, high = kAcceleration;
    const double z1 = slope(x), z2 = bend(x) * s;
    if (std::abs(z1) > 1e-9) {
      const double a = (-kAcceleration - z2) / z1, b = (kAcceleration - z2) / z1;
      low = std::max(low, std::min(a, b));
      high = std::min(high, std::max(a, b));
    }
    return std::pair{low, high};
  };
  for (int i = 0; i <= n; ++i) {
    const double x = i * h, z1 = slope(x), z2 = bend(x);
    double s = kFeed * kFeed / (1 + z1 * z1);
    // Largest s for which the range of u is not empty.
    if (z2 != 0) s = std::min(s, kAcceleration * (1 + std::abs(z1)) / std::abs(z2));
    limit[static_cast<std::size_t>(i)] = s;
  }
  square[n] = 0;
  for (int i = n - 1; i >= 0; --i) {
    const auto k = static_cast<std::size_t>(i);
    const double low = range((i + 1) * h, square[k + 1]).first;
    square[k] = std::min(limit[k], std::max(0.0, square[k + 1] - 2 * h * low));
  }
  square[0] = 0;
  double time = 0;
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double high = range(i * h, square[k]).second;
    square[k + 1] = std::min(square[k + 1], std::max(0.0, square[k] + 2 * h * high));
    time += 2 * h / (std::sqrt(square[k]) + std::sqrt(square[k + 1]));
  }
  return time;
}

double run_time(const std::vector<Move>& moves, double jerk) {
  Kernel kernel(machine_of(3, jerk));
  motion::Sample sample;
  kernel.set_position({});
  std::size_t next = 0;
  double periods = 0;
  do {
    while (next < moves.size() && kernel.can_push()) kernel.push(moves[next++]);
    if (next == moves.size()) kernel.finish();
    while (kernel.plan()) {
    }
    sample = kernel.step({}, 0, 0);
    ++periods;
  } while (!sample.queue_empty);
  return periods * 0.001;
}

void look_ahead(benchmark::State& state) {
  Kernel kernel(machine_of(5, state.range(0) ? 50'000 : 1e12));
  const auto moves = surface(10, 0.2);
  const std::size_t count = std::min(moves.size(), Kernel::kQueueMoves - 1);
  for (auto _ : state) {
    kernel.set_position({});
    kernel.step({}, 0, 0);
    for (std::size_t i = 0; i < count; ++i) kernel.push(moves[i]);
    kernel.finish();
    while (kernel.plan()) {
    }
  }
  state.counters["segments/s"] =
      benchmark::Counter(static_cast<double>(count), benchmark::Counter::kIsIterationInvariantRate);
}

void period(benchmark::State& state) {
  std::vector<double> costs;
  const auto moves = surface(10, 0.2);
  for (auto _ : state) {
    Kernel kernel(machine_of(5, 50'000));
    kernel.set_position({});
    for (std::size_t i = 0; i < 4000; ++i) kernel.push(moves[i]);
    kernel.finish();
    while (kernel.plan()) {
    }
    bool empty = false;
    while (!empty) {
      while (kernel.plan()) {
      }
      const auto from = std::chrono::steady_clock::now();
      empty = kernel.step({}, 0, 0).queue_empty;
      costs.push_back(
          std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - from).count());
    }
  }
  std::sort(costs.begin(), costs.end());
  state.counters["p50_us"] = costs[costs.size() / 2];
  state.counters["p99.9_us"] = costs[costs.size() * 999 / 1000];
  state.counters["max_us"] = costs.back();
}

/// Time a straight step of `way` takes from rest to rest.
double step_over(double way, double jerk) {
  if (jerk >= 1e9) return 2 * std::sqrt(way / kAcceleration);
  const double ramp = kAcceleration / jerk;  // of the acceleration, when it reaches its limit
  const double short_way = 2 * jerk * ramp * ramp * ramp;
  if (way <= short_way) return 4 * std::cbrt(way / (2 * jerk));
  return ramp + std::sqrt(ramp * ramp + 4 * way / kAcceleration);
}

/// `bound`: under v and a limits. `optimum`: under v, a and j limits, by another method. Both with the 0.5 mm
/// to the next pass.
void surf(benchmark::State& state) {
  const double jerk = static_cast<double>(state.range(0));
  double time = 0, as_programmed = 0, bound = 0, optimum = 0;
  for (auto _ : state) {
    time = run_time(surface(20), jerk);
    as_programmed = run_time(surface(20, 0, Corners::round), jerk);
    bound = 19 * step_over(0.5, 1e12);
    optimum = 19 * step_over(0.5, jerk);
    for (int pass = 0; pass < 20; ++pass) {
      const double y = 0.5 * pass, across = std::cos(0.5 * y);
      bound += bound_of_pass(y);
      bench::Wave wave;
      wave.slope = [=](double x) { return 1.6 * std::cos(0.8 * x) * across; };
      wave.bend = [=](double x) { return -1.28 * std::sin(0.8 * x) * across; };
      wave.twist = [=](double x) { return -1.024 * std::cos(0.8 * x) * across; };
      wave.length = 40;
      optimum += bench::optimal_time(wave, {kFeed, kAcceleration, jerk}, 400);
    }
  }
  state.counters["time_s"] = time;
  state.counters["bound_s"] = bound;
  state.counters["optimum_s"] = optimum;
  state.counters["to_bound"] = time / bound;
  state.counters["as_programmed_to_bound"] = as_programmed / bound;
  state.counters["to_optimum"] = time / optimum;
}

BENCHMARK(look_ahead)->ArgName("jerk_limited")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);
BENCHMARK(period)->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(surf)
    ->ArgName("jerk")
    ->Arg(1'000'000'000'000)
    ->Arg(500'000)
    ->Arg(50'000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
