#include "optimal_time.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace headstock::bench {
namespace {

constexpr double kInfeasible = std::numeric_limits<double>::infinity();
using Vector = std::vector<double>;

/// c · (x[k-1], x[k], x[k+1]) <= bound, the left side times sqrt(x[k]) for jerk.
struct Row {
  std::size_t k;
  std::array<double, 3> c;
  double bound;
  bool jerk;
};

class Problem {
 public:
  Problem(const Wave& wave, const AxisLimits& limits, int cells)
      : n_(static_cast<std::size_t>(cells)), h_(wave.length / cells), cap_(n_ + 1) {
    for (std::size_t k = 0; k <= n_; ++k) {
      const double slope = wave.slope(static_cast<double>(k) * h_);
      cap_[k] = limits.feed * limits.feed / (1 + slope * slope);
    }
    for (std::size_t k = 0; k < n_; ++k) {
      const double p = (static_cast<double>(k) + 0.5) * h_;
      accelerate(k, 1, 0, limits.acceleration);
      accelerate(k, wave.slope(p), wave.bend(p), limits.acceleration);
    }
    for (std::size_t k = 1; k < n_ && limits.jerk < 1e9; ++k) {
      const double p = static_cast<double>(k) * h_;
      jerk(k, 1, 0, 0, limits.jerk);
      jerk(k, wave.slope(p), wave.bend(p), wave.twist(p), limits.jerk);
    }
  }

  double solve() {
    Vector x(n_ + 1, 0);
    for (std::size_t k = 1; k < n_; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(n_);
      x[k] = 0.7 * std::pow(6 * 40 * share * (1 - share), 4.0 / 3);
    }
    for (double weight = 0.1; weight > 1e-9; weight *= 0.3)
      for (int i = 0; i < 60 && improve(x, weight); ++i) {
      }
    double time = 0;
    for (std::size_t k = 0; k < n_; ++k) time += step_time(x, k);
    return time;
  }

 private:
  void both_ways(std::size_t k, std::array<double, 3> c, double bound, bool is_jerk) {
    rows_.push_back({k, c, bound, is_jerk});
    rows_.push_back({k, {-c[0], -c[1], -c[2]}, bound, is_jerk});
  }
  void accelerate(std::size_t k, double d1, double d2, double bound) {
    both_ways(k, {0, d2 / 2 - d1 / (2 * h_), d2 / 2 + d1 / (2 * h_)}, bound, false);
  }
  void jerk(std::size_t k, double d1, double d2, double d3, double bound) {
    const double second = d1 / (2 * h_ * h_), first = 3 * d2 / (4 * h_);
    both_ways(k, {second - first, d3 - 2 * second, second + first}, bound, true);
  }
  double step_time(const Vector& x, std::size_t k) const {
    return 2 * h_ / (std::sqrt(x[k]) + std::sqrt(x[k + 1]));
  }
  double left(const Row& row, const Vector& x) const {
    const double side =
        row.c[1] * x[row.k] + row.c[2] * x[row.k + 1] + (row.k > 0 ? row.c[0] * x[row.k - 1] : 0);
    return row.bound - (row.jerk ? side * std::sqrt(x[row.k]) : side);
  }
  double merit(const Vector& x, double weight) const {
    double sum = 0;
    for (std::size_t k = 1; k < n_; ++k) {
      if (!(x[k] > 0 && x[k] < cap_[k])) return kInfeasible;
      sum -= weight * std::log(cap_[k] - x[k]);
    }
    for (std::size_t k = 0; k < n_; ++k) sum += step_time(x, k);
    for (const Row& row : rows_) {
      const double room = left(row, x);
      if (!(room > 0)) return kInfeasible;
      sum -= weight * std::log(room);
    }
    return sum;
  }

  /// One Newton step with line search. @return false: nothing more to gain at this weight.
  bool improve(Vector& x, double weight) {
    Vector gradient(n_ + 1, 0), h0(n_ + 1, 0), h1(n_ + 1, 0), h2(n_ + 1, 0);
    for (std::size_t k = 1; k < n_; ++k) {
      const double room = cap_[k] - x[k], a = std::sqrt(x[k]);
      gradient[k] += weight / room;
      h0[k] += weight / (room * room);
      for (const std::size_t other : {k - 1, k + 1}) {
        const double b = std::sqrt(x[other]), sum = a + b;
        gradient[k] -= h_ / (a * sum * sum);
        h0[k] += h_ * (0.5 / (a * a * a * sum * sum) + 1 / (a * a * sum * sum * sum));
        if (other == k + 1 && other < n_) h1[k] += h_ / (a * b * sum * sum * sum);
      }
    }
    for (const Row& row : rows_) {
      const double room = left(row, x), scale = weight / (room * room);
      std::array<double, 3> g = row.c;
      if (row.jerk) {  // the small negative curvature of the square root is left out: the matrix stays
                       // definite
        const double root = std::sqrt(x[row.k]), side = (row.bound - room) / root;
        for (double& value : g) value *= root;
        g[1] += 0.5 * side / root;
      }
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t at = row.k + i;  // one more than the index
        if (at < 2 || at > n_) continue;
        gradient[at - 1] += weight / room * g[i];
        h0[at - 1] += scale * g[i] * g[i];
        if (i < 2 && at < n_) h1[at - 1] += scale * g[i] * g[i + 1];
        if (i == 0 && at + 1 < n_) h2[at - 1] += scale * g[0] * g[2];
      }
    }
    const Vector step = solve_banded(gradient, h0, h1, h2);
    double gain = 0;
    for (std::size_t k = 1; k < n_; ++k) gain -= gradient[k] * step[k];
    const double before = merit(x, weight);
    for (double share = 1; share > 1e-12; share /= 2) {
      Vector next = x;
      for (std::size_t k = 1; k < n_; ++k) next[k] += share * step[k];
      if (!(merit(next, weight) <= before - 1e-4 * share * gain)) continue;
      x = std::move(next);
      return gain > 1e-3 * weight;
    }
    return false;
  }

  /// Symmetric, five diagonals, unknowns 1 … n-1: minus the gradient on the right.
  Vector solve_banded(const Vector& g, const Vector& h0, const Vector& h1, const Vector& h2) const {
    Vector d(n_ + 1, 0), l1(n_ + 1, 0), l2(n_ + 1, 0), z(n_ + 1, 0);
    for (std::size_t k = 1; k < n_; ++k) {
      d[k] = h0[k] - l1[k - 1] * l1[k - 1] * d[k - 1] - (k > 1 ? l2[k - 2] * l2[k - 2] * d[k - 2] : 0);
      l1[k] = (h1[k] - l1[k - 1] * d[k - 1] * l2[k - 1]) / d[k];
      l2[k] = h2[k] / d[k];
      z[k] = -g[k] - l1[k - 1] * z[k - 1] - (k > 1 ? l2[k - 2] * z[k - 2] : 0);
    }
    for (std::size_t k = 1; k < n_; ++k) z[k] /= d[k];
    for (std::size_t k = n_ - 1; k >= 1; --k) {
      if (k + 1 < n_) z[k] -= l1[k] * z[k + 1];
      if (k + 2 < n_) z[k] -= l2[k] * z[k + 2];
    }
    return z;
  }

  std::size_t n_;
  double h_;
  Vector cap_;
  std::vector<Row> rows_;
};

}  // namespace

double optimal_time(const Wave& wave, const AxisLimits& limits, int cells) {
  return Problem(wave, limits, cells).solve();
}

}  // namespace headstock::bench
