// What an interpreter keeps for canned cycles. The cycles themselves live in cycles/; these are the places
// where they take part in the execution of blocks.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "dialects/dialect.hpp"
#include "machine/axes.hpp"
#include "program/block.hpp"

namespace headstock::interp {

struct Executor;

/// A cycle in progress: asked for its next operation before the next block is read. Operations are made one
/// by one, so a cycle of a million moves needs no memory for them.
class MoveSource {
 public:
  virtual ~MoveSource() = default;
  /// Emits at least one operation. @return false when nothing was left to emit: the cycle is over.
  virtual bool next(Executor& ex) = 0;
};

/// Watches the blocks of a profile (N p … N q) while they are read for a roughing cycle or cut by G70.
class BlockWatch {
 public:
  virtual ~BlockWatch() = default;
  /// Before a block is carried out. @return false after raising an alarm.
  virtual bool admit(Executor& ex) = 0;
  /// After it. May end the watch.
  virtual bool done(Executor& ex, bool has_sequence, std::uint32_t sequence) = 0;
};

/// Words of the single turning cycles G90, G92, G94: modal until another code of group 01 or a one-shot code.
struct BoxWords {
  dialects::Handler owner = nullptr;            ///< whose words they are; nullptr: none
  std::array<double, machine::kMaxAxes> end{};  ///< target, slide mm from the work zero
  std::uint32_t given = 0;                      ///< axes that have a target
  double taper = 0;                             ///< R, mm as programmed (radius, or along Z for G94)
  double runout_short = -1, runout_long = -1;   ///< J, K of threads [mm]; < 0: not given
  double run_in = 0;                            ///< K of 200T threads [mm]
  std::int64_t starts = 1;                      ///< L
};

/// Words of the hole cycles: modal until G80 or a code of group 01.
struct HoleWords {
  const dialects::GCode* code = nullptr;  ///< in force; nullptr: no hole cycle
  bool entered = false;                   ///< the initial level is known
  bool clamp = false;                     ///< the rotary axis is clamped for each hole
  std::size_t axis = 0;                   ///< drilling axis
  double initial = 0;                     ///< level where the mode was entered, slide mm from the work zero
  double bottom = 0, reference = 0;       ///< Z and R, resolved, slide mm
  double peck = 0, dwell_s = 0, retract = 0;  ///< Q, P, K (200T) [mm, s]
  bool has_bottom = false, has_reference = false;
  double shift[2] = {0, 0};  ///< I and J of G76/G87 where they replace Q [mm]
  bool rigid = false;        ///< M29 was commanded for this tapping
  double lead_mm = 0;        ///< lead of a tap given by F or I; 0: from the feed
  double travel_mm_min = 0;  ///< I of small-hole pecking; 0: not given
};

/// The last complete thread, for the controls that can repeat one.
struct LastThread {
  bool valid = false;
  double end_first = 0, end_second = 0, taper = 0, lead_mm = 0;
  double runout_at = 0, runout_short = 0, run_in = 0;
  std::int64_t starts = 1;
};

struct CycleState {
  std::unique_ptr<MoveSource> running;
  std::unique_ptr<BlockWatch> watch;
  const char* name = nullptr;  ///< rides on every motion while a cycle makes it; static storage

  BoxWords box;
  HoleWords hole;
  const dialects::GCode* hole_ended = nullptr;  ///< the mode that this block's codes end
  LastThread last_thread;
  double retreat_ratio = 1;  ///< J/K of the thread cycle being made (K2000TC)
  bool small_holes = false;  ///< 0i-M: G83 is small-hole pecking, until G80 or RESET
  std::int32_t clamp_m =
      0;  ///< M code that clamps the rotary axis inside hole cycles, the next number frees it; 0: none
  double runout_tenths =
      -1;  ///< r of G76, P of G92 where both share it (K2000TC), 0.1 lead; < 0: never given
  std::int32_t driven_m = 0;  ///< M13, M14: the driven tool turns; 0 after M15
  int rigid_tap_axis = -1;    ///< G84, G88 as codes of group 01: the axis that taps in step; -1: none
  bool rigid_next = false;    ///< M29 stands: the next tapping cycle is rigid

  /// Where the profile of the last roughing cycle stands, so that G70 finds the same one.
  struct Place {
    std::uint32_t program = 0, first = 0, last = 0;
    std::uint64_t offset = 0;
    std::uint32_t line = 0;
    bool valid = false;
  } profile;

  /// M codes and ends of the block that started a cycle wait for the cycle's end.
  bool starts_cycle = false;  ///< the block being carried out started one
  std::unique_ptr<program::Block> deferred;

  void clear() {
    running.reset();
    watch.reset();
    deferred.reset();
    name = nullptr;
    box = {};
    hole = {};
    rigid_next = starts_cycle = small_holes = false;
    rigid_tap_axis = -1;
    profile.valid = false;
  }

  /// Which modal words a block's codes end.
  void on_codes(const dialects::GCode* motion, const dialects::GCode* action,
                const dialects::GCode* new_hole) {
    constexpr std::int16_t kDwell = 40;
    if (motion != nullptr && motion->handler != box.owner) box.owner = nullptr;
    if (motion != nullptr && motion->tenths != 840 && motion->tenths != 880) rigid_tap_axis = -1;
    if (action != nullptr && action->tenths != kDwell && action->handler != box.owner) box.owner = nullptr;
    if (new_hole != nullptr) {
      box.owner = nullptr;
      if (hole.code == nullptr) hole = {};
      hole.code = new_hole;
    } else if (motion != nullptr && hole.code != nullptr) {
      hole_ended = hole.code;
      hole = {};
    }
    if (box.owner == nullptr) box.given = 0;
  }
};

}  // namespace headstock::interp
