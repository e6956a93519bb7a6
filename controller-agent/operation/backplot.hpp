// A program's path as poly-lines, for drawing: one piece a move, in work coordinates, arcs as chords.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "interpreter/interpreter.hpp"
#include "machine/machine.hpp"
#include "operation/timing.hpp"

namespace headstock::operation {

enum class PlotKind : char { rapid = 'r', feed = 'f', arc = 'a', thread = 't' };

struct PlotMove {
  PlotKind kind = PlotKind::rapid;
  std::uint32_t line = 0;     ///< of the source
  std::uint32_t program = 0;  ///< O number it stands in
  /// Points of all axes one after the other, the start left out (it is the end of the move before); axis 0 of
  /// point 0, axis 1 of point 0, … Work coordinates in mm, X as a slide position (radius), so that the
  /// drawing has true angles.
  std::vector<float> points;
};

struct Backplot {
  std::vector<char> axes;    ///< names, in the order of the points
  std::vector<float> start;  ///< where the first move begins
  std::vector<PlotMove> moves;
  machine::AxisVector min_mm{}, max_mm{};  ///< of the points shown
  bool truncated = false;                  ///< stopped at max_points
  std::string alarm_code;                  ///< an alarm ended the program here; empty: none
  interp::SourcePosition alarm_at;
};

struct BackplotLimits {
  double chord_mm = 0.05;  ///< an arc's chord leaves it by at most this; > 0
  std::size_t max_points = 200'000;
  std::uint64_t max_operations = 5'000'000;
  const std::atomic<bool>* cancel = nullptr;
};

/// @param main opened once. Any thread.
Backplot backplot(const machine::Machine& machine, interp::MachineData data, const OpenProgram& main,
                  std::shared_ptr<program::Programs> sub_programs, const interp::Switches& switches = {},
                  const BackplotLimits& limits = {});

}  // namespace headstock::operation
