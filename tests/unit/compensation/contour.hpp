// A reference for compensated paths that shares no code with the interpreter: contours as plain segments,
// distances measured point by point.
#pragma once

#include <string>
#include <vector>

namespace headstock::reference {

struct Xy {
  double x = 0, y = 0;
};

struct Piece {
  Xy from, to;
  int turn = 0;  ///< 0 line, +1 counter-clockwise, -1 clockwise arc
  Xy center;
};

Piece line(Xy from, Xy to);
/// An arc that leaves `from` in the direction `heading` [rad] and turns by `angle` [rad] at `radius`.
Piece arc(Xy from, double heading, double radius, double angle);
double heading_at_start(const Piece& piece);
double heading_at_end(const Piece& piece);
double length(const Piece& piece);
/// Point at a fraction 0…1 of the way.
Xy point(const Piece& piece, double fraction);
double distance(Xy from, const Piece& to);
double distance(Xy from, const std::vector<Piece>& to);

/// End points and centres are written with three decimals: the centre, the start and the end of an arc are
/// off by up to 0.7 µm each, and the straight way where vectors were deleted may be 1 µm too near.
inline constexpr double kTolerance = 0.003;
/// Blocks of `program_around` before the contour's first: piece i is line i + kLinesBefore + 1.
inline constexpr unsigned kLinesBefore = 2;
/// A program for a mill that comes to the contour's start, follows it with G41 (side > 0) or G42 and leaves
/// it.
std::string program_around(const std::vector<Piece>& contour, int side);

/// X Y words with three decimals, arcs with I J.
std::string block(const Piece& piece);
/// The piece as the control reads it: end points rounded to 0.001, the centre from rounded I J.
std::vector<Piece> as_programmed(const std::vector<Piece>& contour);

struct Made {
  std::vector<Piece> path;      ///< motions of the tool's centre, in order
  std::vector<unsigned> lines;  ///< source line of each
  std::string alarm;            ///< code; empty: none
};
/// Interprets the program on a mill whose tool 1 has the radius.
Made run(const std::string& program, double radius, const std::string& parameters = "{}");

}  // namespace headstock::reference
