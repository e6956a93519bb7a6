// G71 and G72 with G70 behind them, from the program's text: thousands of random profiles outside and inside,
// toward both sides. Judged by contours as plain pieces (../compensation/contour.hpp) that share nothing with
// the cycles: roughing stays beyond the finishing allowance and leaves no more than it, G70 runs the written
// contour.
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

constexpr double kFinished_mm = 0.0005;  // the half micrometre
constexpr double kRough_mm = 0.0015;     // levels are rounded to the least increment
constexpr double kBeside_mm = 0.002;

struct Control {
  const char* profile;
  const char* feed_mode;
  const char* setup;  ///< of the two-block form, with depth and retract
};
constexpr Control kControls[] = {{"fanuc-0i-t", "G98", "U%.3f R%.3f"},
                                 {"gsk-2000tc", "G98", "U%.3f R%.3f"},
                                 {"gsk-218t", "G98", "U%.3f R%.3f"},
                                 {"k2000tc", "G98", "U%.3f R%.3f"}};

// One job in the view of its cuts: x along the cuts, y away from the axis of the work (or of its face); `out`
// and `on` say how they lie on the machine.
struct Job {
  std::vector<Piece> contour;  ///< on the machine: x is Z, y is the radius
  Xy start;
  int on = -1;  ///< sign of Z along the contour
  int out = 1;  ///< +1: outside
  bool facing = false;
  double depth = 1, retract = 0.5;
  double allow_z = 0, allow_x = 0;  ///< W, and half of U
};

double micron(double value) {
  return std::round(value * 1000) / 1000;
}

Job random_job(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto pick = [&](int count) { return std::uniform_int_distribution<int>(0, count - 1)(random); };
  Job job;
  job.facing = pick(4) == 0;
  job.on = pick(4) == 0 ? 1 : -1;
  job.out = pick(3) == 0 ? -1 : 1;
  job.depth = micron(between(0.4, 3));
  job.retract = micron(between(0.1, 0.9));
  const bool allowed = pick(5) != 0;
  // The tool stands back from the work along both; the allowance points to where it stands.
  job.allow_x = allowed ? job.out * micron(between(0, 0.4)) : 0;
  job.allow_z = allowed ? -job.on * micron(between(0, 0.3)) : 0;
  const double first_radius = job.out > 0 ? micron(between(8, 20)) : micron(between(60, 80));
  Xy at{micron(between(-5, 5)), first_radius};
  const Xy first = at;
  const int count = 1 + pick(7);
  for (int i = 0; i < count; ++i) {
    double along = micron(between(0.5, 9)), away = micron(between(0.5, 5));
    const int kind = pick(4);
    if (kind == 0 && i > 0) along = 0;
    if (kind == 1) away = 0;
    const Xy to{at.x + job.on * along, at.y + job.out * away};
    if (kind >= 2 && pick(2) == 0) {
      // An arc that never turns back: half its sweep is at most the angle between the chord and the nearer
      // axis.
      const double chord = std::hypot(along, away);
      const double half = std::atan2(std::min(along, away), std::max(along, away)) * between(0.3, 0.95);
      const double radius = micron(chord / 2 / std::sin(half) + 0.01);
      const double height = std::sqrt(radius * radius - chord * chord / 4);
      const int turn = pick(2) == 0 ? 1 : -1;
      const double ux = (to.x - at.x) / chord, uy = (to.y - at.y) / chord;
      Piece piece{at, to, turn, {}};
      piece.center = {(at.x + to.x) / 2 - turn * uy * height, (at.y + to.y) / 2 + turn * ux * height};
      job.contour.push_back(piece);
    } else {
      job.contour.push_back(line(at, to));
    }
    at = to;
  }
  if (job.facing) {  // from the far end of the same shape back to its beginning: cuts lie along X
    std::reverse(job.contour.begin(), job.contour.end());
    for (Piece& p : job.contour) {
      std::swap(p.from, p.to);
      p.turn = -p.turn;
    }
  }
  const double beyond = micron(between(0.8, 4));
  job.start = {first.x - job.on * micron(between(0.8, 3)), at.y + job.out * beyond};
  return job;
}

std::string program_of(const Job& job, const Control& control) {
  char text[200];
  const char* const code = job.facing ? "G72" : "G71";
  std::snprintf(text, sizeof text, "O0001\n%s G00 X%.3f Z%.3f\n", control.feed_mode, 2 * job.start.y,
                job.start.x);
  std::string program = text;
  char setup[80];
  std::snprintf(setup, sizeof setup, control.setup, job.depth, job.retract);
  if (job.facing) setup[0] = 'W';
  program += std::string(code) + " " + setup + "\n";
  std::snprintf(text, sizeof text, "%s P10 Q20 U%.3f W%.3f F200\n", code, 2 * job.allow_x, job.allow_z);
  program += text;
  const Xy first = job.contour.front().from;
  std::snprintf(text, sizeof text, job.facing ? "N10 G00 Z%.3f\n" : "N10 G00 X%.3f\n",
                job.facing ? first.x : 2 * first.y);
  program += text;
  std::snprintf(text, sizeof text, job.facing ? "G01 X%.3f\n" : "G01 Z%.3f\n",
                job.facing ? 2 * first.y : first.x);
  program += text;
  for (std::size_t i = 0; i < job.contour.size(); ++i) {
    const Piece& p = job.contour[i];
    if (i + 1 == job.contour.size()) program += "N20 ";
    if (p.turn == 0) {
      std::snprintf(text, sizeof text, "G01 X%.3f Z%.3f\n", 2 * p.to.y, p.to.x);
    } else {
      std::snprintf(text, sizeof text, "%s X%.3f Z%.3f R%.3f\n", p.turn > 0 ? "G03" : "G02", 2 * p.to.y,
                    p.to.x, std::hypot(p.from.x - p.center.x, p.from.y - p.center.y));
    }
    program += text;
  }
  return program + "G70 P10 Q20\nM30\n";
}

struct Cut {
  std::vector<Piece> roughing, finishing;  ///< at feed
  std::string alarm;
};

Cut cut(const std::string& program, const char* profile, Xy start) {
  const machine::Machine machine = *machine::default_machine(profile);
  std::size_t x = 0, z = 1;
  for (std::size_t i = 0; i < machine.axes.size(); ++i) (machine.axes[i].name == 'X' ? x : z) = i;
  interp::MachineData data;
  interp::Interpreter interpreter(*dialects::find(profile), machine, data, nullptr);
  machine::AxisVector at_start{};
  at_start[x] = start.y;
  at_start[z] = start.x;
  interpreter.start(program::source_from_text(program), at_start);
  Cut result;
  Xy at = start;
  interp::Operation op;
  while (interpreter.next(op) == interp::Pull::operation) {
    if (const auto* alarm = std::get_if<interp::Alarm>(&op)) result.alarm = alarm->code + ' ' + alarm->detail;
    const interp::Motion* motion = nullptr;
    Piece piece;
    if (const auto* rapid = std::get_if<interp::Rapid>(&op)) motion = rapid;
    if (const auto* feed = std::get_if<interp::Feed>(&op)) motion = feed;
    if (const auto* a = std::get_if<interp::Arc>(&op)) {
      motion = a;
      piece.turn = a->turn == interp::Turn::ccw ? 1 : -1;
      piece.center = {a->center_machine[z], a->center_machine[x]};
    }
    if (motion == nullptr) continue;
    piece.from = at;
    at = piece.to = {motion->end_machine[z], motion->end_machine[x]};
    if (motion->cycle == nullptr || std::holds_alternative<interp::Rapid>(op)) continue;
    (std::string_view(motion->cycle) == "G70" ? result.finishing : result.roughing).push_back(piece);
  }
  return result;
}

// Whether a point lies in the work by more than `depth`: nearer than that to the contour is neither.
bool inside_work(const Job& job, const std::vector<Piece>& contour, Xy q, double depth) {
  // On the work's side of the contour's piece under (or beside) the point.
  if (distance(q, contour) <= depth) return false;
  for (const Piece& p : contour) {
    const double low = std::min(p.from.x, p.to.x), high = std::max(p.from.x, p.to.x);
    if (q.x < low || q.x > high || high - low < 1e-9) continue;
    double near = 0, far = 1;  // the contour never turns back: where it passes over q.x
    for (int i = 0; i < 60; ++i) {
      const double half = (near + far) / 2;
      ((point(p, half).x - q.x) * (p.to.x - p.from.x) < 0 ? near : far) = half;
    }
    return job.out * (q.y - point(p, near).y) < 0;
  }
  return false;
}

TEST(Finishing, RoughingKeepsTheAllowanceAndG70RunsTheContour) {
  std::mt19937 random(7071);
  std::size_t cuts = 0;
  for (int i = 0; i < 2'000; ++i) {
    const Job job = random_job(random);
    const Control& control = kControls[i % 4];
    const std::string program = program_of(job, control);
    SCOPED_TRACE(std::string(control.profile) + '\n' + program);
    const Cut made = cut(program, control.profile, job.start);
    ASSERT_EQ(made.alarm, "");
    ASSERT_FALSE(made.roughing.empty());
    cuts += made.roughing.size();

    std::vector<Piece> allowed = job.contour;
    for (Piece& p : allowed) {
      for (Xy* q : {&p.from, &p.to, &p.center}) *q = {q->x + job.allow_z, q->y + job.allow_x};
    }
    for (const Piece& p : made.roughing) {
      for (int k = 0; k <= 16; ++k) {
        const Xy q = point(p, k / 16.0);
        ASSERT_FALSE(inside_work(job, allowed, q, kRough_mm)) << "roughing at Z" << q.x << " X" << 2 * q.y;
      }
    }
    for (const Piece& p : allowed) {  // nothing is left beyond the allowance
      for (int k = 1; k < 20; ++k)
        ASSERT_LT(distance(point(p, k / 20.0), made.roughing), kBeside_mm) << "not cut by the contour pass";
    }

    for (const Piece& p : job.contour) {
      for (int k = 0; k <= 16; ++k) {
        const Xy q = point(p, k / 16.0);
        ASSERT_LT(distance(q, made.finishing), kFinished_mm) << "not finished: Z" << q.x << " X" << 2 * q.y;
      }
    }
    // Behind the way to the contour's first point there is nothing but the contour.
    const Xy first = job.contour.front().from;
    bool on_contour = false;
    for (const Piece& p : made.finishing) {
      for (int k = 0; on_contour && k <= 16; ++k)
        ASSERT_LT(distance(point(p, k / 16.0), job.contour), kFinished_mm) << "beside the contour";
      on_contour = on_contour || std::hypot(p.to.x - first.x, p.to.y - first.y) < kFinished_mm;
    }
    ASSERT_TRUE(on_contour);
  }
  std::printf("roughing cuts %zu\n", cuts);
  EXPECT_GT(cuts, 20'000u);
}

}  // namespace
}  // namespace headstock::reference
