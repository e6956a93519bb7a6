// Direct drawing dimension programming: end points from angles. Pure functions, any thread.
#pragma once

#include <optional>

#include "compensation/geometry.hpp"

namespace headstock::comp {

/// A line from `from` at `angle_deg` (counter-clockwise from the plane's first axis; only the slope counts):
/// where it has the first coordinate `u`. Empty: it runs along the other axis, within `parallel_deg`.
std::optional<Point> at_first(Point from, double angle_deg, double u, double parallel_deg);
/// The same with the second coordinate given.
std::optional<Point> at_second(Point from, double angle_deg, double v, double parallel_deg);

/// Where the line through `from` at the first angle and the line through `to` at the second one meet. Empty:
/// they are parallel within `parallel_deg`.
std::optional<Point> meet(Point from, double first_deg, Point to, double second_deg, double parallel_deg);

}  // namespace headstock::comp
