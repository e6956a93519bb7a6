#include "random_programs.hpp"

#include <cmath>
#include <optional>
#include <random>

#include "rig.hpp"

namespace headstock::motion::rig {
namespace {

struct Chance {
  std::mt19937 generator;
  double one() { return std::uniform_real_distribution<double>(-1, 1)(generator); }
  bool once_in(unsigned n) { return generator() % n == 0; }
  double decades(double around, double width) { return std::pow(10.0, around + width * one()); }
};

struct Pen {
  AxisVector at{};
  double heading = 0;
};

Arc turn_about(Pen& pen, double x, double y, double angle) {
  Arc arc;
  arc.center_1 = pen.at[0] - x;
  arc.center_2 = pen.at[1] - y;
  arc.angle_rad = angle;
  pen.at[0] = arc.center_1 + std::cos(angle) * x - std::sin(angle) * y;
  pen.at[1] = arc.center_2 + std::sin(angle) * x + std::cos(angle) * y;
  return arc;
}

void forward(Pen& pen, double length) {
  pen.at[0] += length * std::cos(pen.heading);
  pen.at[1] += length * std::sin(pen.heading);
}

void anywhere(Pen& pen, Chance& chance, double size) {
  for (std::size_t k = 0; k < 3; ++k)
    if (!chance.once_in(3)) pen.at[k] += chance.one() * size;
}

}  // namespace

std::vector<Move> random_program(unsigned seed, std::size_t count) {
  constexpr double kTolerances[] = {0.01, 0.003, 0.05};
  Chance chance{std::mt19937(seed * 7919u + 13u)};
  const double scale = chance.decades(-0.5, 2);
  const unsigned kind = seed % 8;
  std::vector<Move> moves;
  Pen pen;
  for (std::size_t i = 0; i < count; ++i) {
    double size = scale;
    Move move = line({}, kind < 4 ? 5 + 200 * std::abs(chance.one()) : 100, kTolerances[seed / 8 % 3]);
    std::optional<Arc> arc;
    switch (kind) {
      case 1:
        anywhere(pen, chance, chance.decades(-1, 2));
        break;
      case 2:
        anywhere(pen, chance, chance.once_in(4) ? 5 : 0.1);
        break;
      case 3:
        if (chance.once_in(2)) {
          arc = turn_about(pen, chance.one() * size, chance.one() * size, 7 * chance.one());
          if (chance.once_in(2)) pen.at[2] += chance.one() * size;
        } else {
          anywhere(pen, chance, size);
        }
        break;
      case 4: {
        const double t = 0.1 * static_cast<double>(i + 1);
        pen.at = {t, 0.3 * std::sin(1.7 * t + seed), 2 * std::sin(0.8 * t) * std::cos(0.1 * seed)};
        break;
      }
      case 5:
        pen.heading += 0.3 * chance.one();
        size = 0.05 + 0.15 * std::abs(chance.one());
        forward(pen, size);
        pen.at[2] += 0.1 * size * chance.one();
        break;
      case 6:
        pen.heading += chance.once_in(10) ? 2 * chance.one() : 0.05 * chance.one();
        forward(pen, chance.decades(-0.5, 1.5));
        break;
      case 7: {
        // Centre to the left (+) or the right of the heading: the arc leaves along it.
        const double radius = chance.decades(0, 1.5) * (chance.once_in(2) ? 1 : -1);
        const double angle = std::copysign(0.1 + 3 * std::abs(chance.one()), radius);
        arc = turn_about(pen, radius * std::sin(pen.heading), -radius * std::cos(pen.heading), angle);
        pen.heading += angle;
        break;
      }
      default:
        anywhere(pen, chance, size);
    }
    if (arc) {
      arc->end = pen.at;
      move.geometry = *arc;
    } else {
      move.geometry = Line{pen.at};
    }
    move.exact_stop = chance.once_in(20);
    move.tag = i + 1;
    moves.push_back(move);
  }
  return moves;
}

AxisVector end_of(const Move& move) {
  return std::visit([](const auto& geometry) { return geometry.end; }, move.geometry);
}

}  // namespace headstock::motion::rig
