#include "contour.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "machine/machine.hpp"

namespace headstock::reference {
namespace {

constexpr double kFull = 2 * std::numbers::pi;

double angle_of(Xy p, Xy center) {
  return std::atan2(p.y - center.y, p.x - center.x);
}

double sweep(const Piece& piece) {
  double angle = piece.turn * (angle_of(piece.to, piece.center) - angle_of(piece.from, piece.center));
  while (angle < 0) angle += kFull;
  while (angle > kFull) angle -= kFull;
  return angle < 1e-9 ? kFull : angle;
}

double rounded(double value) {
  return std::round(value * 1000) / 1000;
}

}  // namespace

Piece line(Xy from, Xy to) {
  return {from, to, 0, {}};
}

Piece arc(Xy from, double heading, double radius, double angle) {
  Piece piece;
  piece.from = from;
  piece.turn = angle > 0 ? 1 : -1;
  piece.center = {from.x - piece.turn * radius * std::sin(heading),
                  from.y + piece.turn * radius * std::cos(heading)};
  const double at = angle_of(from, piece.center) + angle;
  piece.to = {piece.center.x + radius * std::cos(at), piece.center.y + radius * std::sin(at)};
  return piece;
}

double heading_at_start(const Piece& p) {
  if (p.turn == 0) return std::atan2(p.to.y - p.from.y, p.to.x - p.from.x);
  return angle_of(p.from, p.center) + p.turn * kFull / 4;
}

double heading_at_end(const Piece& p) {
  if (p.turn == 0) return heading_at_start(p);
  return angle_of(p.to, p.center) + p.turn * kFull / 4;
}

double length(const Piece& p) {
  if (p.turn == 0) return std::hypot(p.to.x - p.from.x, p.to.y - p.from.y);
  return sweep(p) * std::hypot(p.from.x - p.center.x, p.from.y - p.center.y);
}

Xy point(const Piece& p, double f) {
  if (p.turn == 0) return {p.from.x + f * (p.to.x - p.from.x), p.from.y + f * (p.to.y - p.from.y)};
  const double a = angle_of(p.from, p.center) + p.turn * f * sweep(p);
  const double start = std::hypot(p.from.x - p.center.x, p.from.y - p.center.y);
  const double end = std::hypot(p.to.x - p.center.x, p.to.y - p.center.y);
  const double r = start + f * (end - start);
  return {p.center.x + r * std::cos(a), p.center.y + r * std::sin(a)};
}

double distance(Xy q, const Piece& p) {
  if (p.turn == 0) {
    const double dx = p.to.x - p.from.x, dy = p.to.y - p.from.y, l = dx * dx + dy * dy;
    const double t = l > 0 ? std::clamp(((q.x - p.from.x) * dx + (q.y - p.from.y) * dy) / l, 0.0, 1.0) : 0;
    return std::hypot(q.x - p.from.x - t * dx, q.y - p.from.y - t * dy);
  }
  const double ends =
      std::min(std::hypot(q.x - p.from.x, q.y - p.from.y), std::hypot(q.x - p.to.x, q.y - p.to.y));
  double a = p.turn * (angle_of(q, p.center) - angle_of(p.from, p.center));
  while (a < 0) a += kFull;
  while (a > kFull) a -= kFull;
  const double whole = sweep(p);
  if (a > whole) return ends;
  // Rounded words: the radius goes from that of the start to that of the end.
  const double start = std::hypot(p.from.x - p.center.x, p.from.y - p.center.y);
  const double r = start + a / whole * (std::hypot(p.to.x - p.center.x, p.to.y - p.center.y) - start);
  return std::min(ends, std::fabs(std::hypot(q.x - p.center.x, q.y - p.center.y) - r));
}

double distance(Xy from, const std::vector<Piece>& to) {
  double least = 1e300;
  for (const Piece& piece : to) least = std::min(least, distance(from, piece));
  return least;
}

std::string block(const Piece& p) {
  char text[160];
  if (p.turn == 0) {
    std::snprintf(text, sizeof text, "G01 X%.3f Y%.3f\n", p.to.x, p.to.y);
  } else {
    std::snprintf(text, sizeof text, "%s X%.3f Y%.3f I%.3f J%.3f\n", p.turn > 0 ? "G03" : "G02", p.to.x,
                  p.to.y, p.center.x - p.from.x, p.center.y - p.from.y);
  }
  return text;
}

std::vector<Piece> as_programmed(const std::vector<Piece>& contour) {
  std::vector<Piece> out;
  for (Piece p : contour) {
    const Xy arm{rounded(p.center.x - p.from.x), rounded(p.center.y - p.from.y)};
    p.from = out.empty() ? Xy{rounded(p.from.x), rounded(p.from.y)} : out.back().to;
    p.to = {rounded(p.to.x), rounded(p.to.y)};
    p.center = {p.from.x + arm.x, p.from.y + arm.y};
    out.push_back(p);
  }
  return out;
}

std::string program_around(const std::vector<Piece>& contour, int side) {
  std::string program = side > 0 ? "G90 G94 G00 X-30. Y0\nG41 G01 X0 Y0 D1 F500\n"
                                 : "G90 G94 G00 X-30. Y0\nG42 G01 X0 Y0 D1 F500\n";
  for (const Piece& p : contour) program += block(p);
  char leave[100];
  std::snprintf(leave, sizeof leave, "G40 G01 X%.3f Y%.3f\nM30\n", contour.back().to.x + 30,
                contour.back().to.y);
  return program + leave;
}

Made run(const std::string& program, double radius, const std::string& parameters) {
  const dialects::Dialect* dialect = dialects::find("fanuc-0i-m");
  const machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  interp::MachineData data;
  data.tools.resize(3);
  data.tools[1].radius = radius;
  interp::load_parameters(parameters, data);
  interp::Interpreter interpreter(*dialect, machine, data, nullptr);
  interpreter.start(program::source_from_text(program), {});
  Made result;
  Xy at;
  const auto add = [&](const interp::Motion& m, Piece piece) {
    piece.from = at;
    piece.to = {m.end_machine[0], m.end_machine[1]};
    at = piece.to;
    result.path.push_back(piece);
    result.lines.push_back(m.at.line);
  };
  interp::Operation op;
  while (interpreter.next(op) == interp::Pull::operation) {
    if (const auto* rapid = std::get_if<interp::Rapid>(&op)) add(*rapid, {});
    if (const auto* feed = std::get_if<interp::Feed>(&op)) add(*feed, {});
    if (const auto* a = std::get_if<interp::Arc>(&op)) {
      Piece piece;
      piece.turn = a->turn == interp::Turn::ccw ? 1 : -1;
      piece.center = {a->center_machine[0], a->center_machine[1]};
      add(*a, piece);
    }
    if (const auto* alarm = std::get_if<interp::Alarm>(&op)) result.alarm = alarm->code;
  }
  return result;
}

}  // namespace headstock::reference
