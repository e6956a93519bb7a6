// G78.1: a threading cycle inside G07.2, with the spindle as a rotary axis (L4261-L4662).
//
// Of every start: infeed beside the start point, an arc of a quarter circle with radius NB onto the thread, the
// thread, an arc with radius NE off it, retract, and back at rapid while the spindle turns to its next angle by the
// shorter way. The spindle's angle follows from the place on the linear axis alone, so infeed, arcs and thread are
// one turning motion. With NP1 every second start is cut on the way back. The manual's figures are lost: the quarter
// circles are read from its conditions (NB and NE larger than the thread's height, far smaller than the infeed).
#pragma once

#include <cstdint>
#include <vector>

#include "interpreter/canonical.hpp"
#include "interpreter/cycle_state.hpp"

namespace headstock::dialects::k2000tc {

/// The words of G78.1, modal until another code of group 01.
struct SpindleThreadWords {
  double taper_mm = 0;                ///< R: radius at the start less that at the end
  double start_deg = 0;               ///< Q
  double enter_mm = 0, leave_mm = 0;  ///< NB, NE
  bool both_ways = false;             ///< NP1
  std::int64_t starts = 1;            ///< L
};

/// One cycle, its moves made start by start.
class SpindleThreadRun final : public interp::MoveSource {
 public:
  SpindleThreadWords words;
  std::size_t x = 0, z = 0, spindle = 0;
  double x_from = 0, z_from = 0, x_to = 0, z_to = 0;  ///< slide positions in machine coordinates [mm]
  double degrees_a_mm = 0;                            ///< of the linear axis, signed
  double feed = 0;
  interp::FeedUnit unit = interp::FeedUnit::mm_per_minute;

  bool next(interp::Executor& ex) override;

 private:
  struct Step {
    double x, z, spindle;
    bool rapid;
  };
  void plan(double spindle_now);
  void arc(double x_from_mm, double z_from_mm, double x_to_mm, double z_to_mm, bool onto);
  double radius_at(double z_mm) const;
  double angle_at(double z_mm) const { return start_angle_ + degrees_a_mm * (z_mm - z_from); }

  std::vector<Step> steps_;
  std::size_t done_ = 0;
  std::int64_t start_ = 0;
  double start_angle_ = 0;
  bool at_end_ = false;  // beside the thread's end instead of its beginning
};

bool spindle_thread_cycle(interp::Executor& ex);
/// A block with G78.1 and without positions only keeps its words (L4352).
bool take_spindle_thread_words(interp::Executor& ex);

}  // namespace headstock::dialects::k2000tc
