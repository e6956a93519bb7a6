// Speeds that the controllers' parameters allow on arcs, at corners and on short segments: below what the
// axes could do. The limits of the machine file hold whatever these say.
#pragma once

#include "interpreter/machine_data.hpp"
#include "machine/machine.hpp"
#include "motion/geometry.hpp"

namespace headstock::operation {

using machine::AxisVector;

/// 0 everywhere: not limited. Look-ahead thread.
struct SpeedLimits {
  // ---- on arcs: v = √(acceleration × radius), the smaller acceleration of the two axes (0i-D L21749)
  AxisVector arc_acceleration{};  ///< mm/s², per axis (0i-D No. 1735); GSK 2000TC P331 for all
  double arc_least_mm_s = 0;      ///< never below (No. 1732, P332)
  bool arc_always = false;        ///< not only under look-ahead control (2000TC)
  // ---- out of a thread, whatever G code does it
  double retreat_mm_s = 0;  ///< along the path (K2000TC P6484)
  // ---- under look-ahead control (G08, G05.1) only
  AxisVector corner_mm_s{};           ///< most an axis' speed may change at a corner (No. 1783)
  bool corner_alike = false;          ///< the same shape has the same speed in every direction (No. 19500#6)
  AxisVector segment_acceleration{};  ///< mm/s², of a run of short lines (No. 1737)
  double segment_least_mm_s = 0;      ///< never below for that reason (No. 1738)
  AxisVector feed_mm_s{};             ///< most of each axis (No. 1432)
  double highest_mm_s = 0;            ///< along the path (No. 8465)

  /// What the parameters of this controller say; one that is not set limits nothing.
  static SpeedLimits read(const machine::Machine& machine, const interp::MachineData& data);

  /// Highest speed along a move, whatever the override [mm/s]; 0: not limited.
  double along(const motion::Curve& curve, const motion::Move& move, bool look_ahead) const;
  /// Highest speed where two cutting moves meet under look-ahead control [mm/s]; 0: not limited.
  double between(const motion::Curve& from, const motion::Curve& to) const;
  /// Highest speed of short lines that meet at this corner, under look-ahead control [mm/s]; 0: not limited.
  double segments(const motion::Curve& from, const motion::Curve& to) const;
};

}  // namespace headstock::operation
