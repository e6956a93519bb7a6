// Aborts, holds and overrides at random instants: the limits hold, the axes never leave the one path, and
// what stands keeps standing. HEADSTOCK_INSTANTS=10000 motion_test --gtest_filter='Instants*' is the long
// run.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>

#include "random_programs.hpp"
#include "rig.hpp"

namespace headstock::motion {
namespace {

constexpr std::size_t kMoves = 30;

std::size_t instants() {
  const char* many = std::getenv("HEADSTOCK_INSTANTS");
  return many ? static_cast<std::size_t>(std::atol(many)) : 100;
}

machine::Machine machine_for(unsigned seed) {
  constexpr double kJerks[] = {50'000, 500'000, 1e12};
  return rig::machine(3, 300, 2000, kJerks[seed % 3]);
}

/// The path as a run at a tenth of the feed traces it. Another run is on it when its samples can be matched to
/// it in order: each within `kOnPath_mm`, none behind the one before.
class Traced {
 public:
  Traced(const machine::Machine& machine, const std::vector<Move>& moves) {
    rig::Options options;
    options.overrides = [](std::size_t) {
      Overrides slow;
      slow.feed = 0.1;
      return slow;
    };
    auto kernel = std::make_unique<Kernel>(machine);
    points_.push_back({});
    for (const Sample& sample : rig::run(*kernel, machine, moves, options).samples)
      if (sample.position != points_.back()) points_.push_back(sample.position);
  }
  void start() { at_ = 0; }
  /// The next sample of a run. The first chord that is near enough is taken: whatever order fits, this one
  /// leaves most of the path for the samples to come, also where the path crosses or retraces itself.
  bool follows(const AxisVector& position) {
    for (std::size_t k = at_; k < points_.size() && k < at_ + kFarthest; ++k) {
      if (to_chord(k, position) > kOnPath_mm) continue;
      at_ = k;
      return true;
    }
    return false;
  }
  /// Nothing of the path is left to be traced, but for what is near enough anyway.
  bool at_end() const {
    double left = 0;
    for (std::size_t k = at_ + 1; k + 1 < points_.size(); ++k) left += gap(points_[k], points_[k + 1]);
    return left < 10 * kOnPath_mm;
  }

 private:
  static constexpr double kOnPath_mm = 1e-4;       // what the chords of the slow run leave out
  static constexpr std::size_t kFarthest = 2'000;  // chords of the slow run in one period of another

  static double gap(const AxisVector& a, const AxisVector& b) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(sum);
  }
  double to_chord(std::size_t k, const AxisVector& p) const {
    const AxisVector &a = points_[k], &b = points_[std::min(k + 1, points_.size() - 1)];
    double along = 0, square = 0, sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      along += (p[i] - a[i]) * (b[i] - a[i]);
      square += (b[i] - a[i]) * (b[i] - a[i]);
    }
    const double share = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double d = p[i] - a[i] - share * (b[i] - a[i]);
      sum += d * d;
    }
    return std::sqrt(sum);
  }

  std::vector<AxisVector> points_;
  std::size_t at_ = 0;
};

TEST(Instants, AnAbortStandsWhereItIsShownAndNothingStartsByItself) {
  std::mt19937 generator(11);
  for (std::size_t done = 0; done < instants();) {
    const auto seed = static_cast<unsigned>(generator() % 1000);
    const auto machine = machine_for(seed);
    const auto moves = rig::random_program(seed, kMoves);
    auto kernel = std::make_unique<Kernel>(machine);
    const std::size_t periods = rig::run(*kernel, machine, moves).samples.size();
    for (int round = 0; round < 10 && done < instants(); ++round, ++done) {
      const std::size_t at = generator() % periods;
      LimitsCheck limits(3, 0.001);
      PathError error(3);
      kernel->set_position({});
      limits.add({});
      error.start({});
      for (const Move& move : moves) {
        kernel->push(move);
        error.add(move);
      }
      kernel->finish();
      while (kernel->plan()) {
      }
      Sample shown;
      for (std::size_t i = 0; i < at; ++i) limits.add((shown = kernel->step({}, 0, 0)).position);
      kernel->abort();
      for (int i = 0; i < 20'000 && !kernel->aborted(); ++i)
        limits.add((shown = kernel->step({}, 0, 0)).position);
      ASSERT_TRUE(kernel->aborted()) << seed << " at " << at;
      rig::Run run;
      run.velocity = limits.max_velocity();
      run.acceleration = limits.max_acceleration();
      run.jerk = limits.max_jerk();
      EXPECT_EQ(rig::violations(machine, run), "") << seed << " at " << at;
      EXPECT_LE(error.sample(shown.position, shown.tag), moves[0].tolerance_mm) << seed << " at " << at;
      Overrides pressed;  // whatever is pressed: only set_position() and new moves start anything
      for (int i = 0; i < 50; ++i) {
        pressed.feed = 0.05 * i;
        pressed.hold = i % 7 == 0;
        ++pressed.go;
        const Sample later = kernel->step(pressed, 0.1 * i, 1000);
        ASSERT_EQ(later.position, shown.position) << seed << " at " << at;
        ASSERT_FALSE(later.moving);
      }
    }
  }
}

TEST(Instants, HoldAndOverrideKeepLimitsAndThePath) {
  std::mt19937 generator(12);
  for (std::size_t done = 0; done < instants();) {
    const auto seed = static_cast<unsigned>(generator() % 1000);
    const auto machine = machine_for(seed);
    const auto moves = rig::random_program(seed, kMoves);
    Traced path(machine, moves);
    path.start();
    Overrides now;
    rig::Options options;
    std::size_t injected = 0;
    std::size_t off_path = 0;
    options.overrides = [&](std::size_t) {
      if (generator() % 30 != 0) return now;
      ++injected;
      now.hold = generator() % 3 == 0;
      now.feed = static_cast<double>(1 + generator() % 254) / 100;
      return now;
    };
    options.watch = [&](const Sample& sample) {
      off_path += !path.follows(sample.position);
    };
    auto kernel = std::make_unique<Kernel>(machine);
    const auto run = rig::run(*kernel, machine, moves, options);
    EXPECT_TRUE(run.finished) << seed;
    EXPECT_EQ(rig::violations(machine, run), "") << seed;
    EXPECT_LE(run.path_error, moves[0].tolerance_mm) << seed;
    EXPECT_EQ(off_path, 0u) << seed;
    EXPECT_TRUE(path.at_end()) << seed;
    EXPECT_EQ(run.samples.back().position, rig::end_of(moves.back())) << seed;
    done += std::max<std::size_t>(1, injected);
  }
}

}  // namespace
}  // namespace headstock::motion
