// Between what handlers emit and what the interpreter hands out. With nothing active operations pass it by.
// While a chamfer, a corner round, an open drawing dimension or G41/G42 is active, motions are held until
// enough of the following blocks are known; operations that are no motions keep their place between the
// motions that surround them. One object a path; belongs to the interpreter's thread.
//
//   block → Executor::emit → take(): corners (stage 1) → compensation (stage 2) → Executor::next
//
// What is held is bounded: two motions and the operations of a few blocks without motion (more blocks without
// motion settle the corner: the vector normal to the last motion, as the controllers do). An alarm while
// blocks are held is handed out after the motions whose path is settled; the others are not run.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "compensation/rules.hpp"
#include "dialects/alarm_reason.hpp"
#include "interpreter/canonical.hpp"

namespace headstock::interp {

struct Executor;

/// What a block says about the corner at its end.
struct CornerRequest {
  comp::CornerShape shape = comp::CornerShape::none;
  double size_mm = 0;
  std::uint32_t column = 0;
  bool perpendicular = false;   ///< the next block must be a move along the plane's other axis only …
  bool next_is_second = false;  ///< … this one …
  int next_sign = 0;            ///< … in this direction; 0: any
  bool open = false;            ///< the end point is known with the next block (angle only)
  double angle_deg = 0;         ///< of an open line

  bool asked() const { return open || shape != comp::CornerShape::none; }
};

/// The compensation in force when a block was read.
struct CompensationMode {
  bool asked = false;                  ///< G41 or G42 is in force
  bool wanted = false;                 ///< G41 or G42 with an offset number
  double radius = 0;                   ///< signed [mm]: > 0 left of the path
  comp::Point tip;                     ///< from the nose centre to the imaginary tip [mm]
  std::uint8_t first = 0, second = 1;  ///< the plane's axes, indices
  Plane plane = Plane::xy;
  bool again = false;  ///< G41/G42 written in this block though it was in force
};

/// An operation on its way with what is known of it; see pipeline_entry.hpp.
struct PipelineEntry;

/// I J K of a block: a direction in the plane.
struct BlockVector {
  bool given = false;
  comp::Point direction;
};

class Pipeline {
 public:
  Pipeline();
  Pipeline(Pipeline&& other) noexcept;
  Pipeline& operator=(Pipeline&& other) noexcept;
  ~Pipeline();

  /// Whether operations must go through take().
  bool active() const { return active_; }
  /// Whether G41/G42 displaces the path now.
  bool compensating() const { return on_; }
  /// Whether a motion waits for the next one because of a chamfer, a round or an open line.
  bool holds_corner() const { return held_corner_; }
  /// Whether a motion that was emitted waits for following blocks.
  bool holds_motion() const { return held_corner_ || has_last_ || has_previous_; }
  /// G41/G42 have no effect from now on (the profile of a roughing cycle is read).
  void corners_only() { no_compensation_ = true; }
  /// Forgets what is held and the vectors; the path continues where the tool stands.
  void clear();

  // ---- what handlers say about the block being carried out
  void activate(const AxisVector& machine_position, const AxisVector& work_position);
  void ask_corner(const CornerRequest& request) { request_ = request; }
  bool line_is_open() const { return held_corner_ && open_; }
  double open_angle_deg() const { return open_angle_deg_; }
  /// The end of the open line [machine coordinates, page].
  void close_line(const AxisVector& end_machine, const AxisVector& end_work, std::uint32_t moved);
  void block_read() { block_counts_ = true; }    ///< a block that is not empty
  void drop_for_setting() { touch_ = true; }     ///< G50/G92: the vector is dropped and taken again
  void drop_for_block() { lift_block_ = true; }  ///< G28 and the like: this block runs without the vector
  void corner_arc(bool has_direction, comp::Point direction);  ///< G39
  void written(int side, bool same_as_before);                 ///< G40 (0), G41 (1), G42 (-1)
  /// I J K of the block being carried out, in the plane, not of length 0.
  void vector(comp::Point direction) { vector_ = {true, direction}; }
  /// G40 stands in this block and takes a vector off.
  bool cancels_here() const { return on_ && written_here_ && side_ == 0; }
  int side() const { return side_; }

  /// The plane's axes and the tool of the block being carried out; valid until it is asked for again.
  const CompensationMode& mode_of(const Executor& ex);

  /// Before a block: what it emits first is made where it will wait.
  void open_intake(Executor& ex);
  /// Takes all that the block emitted and gives the Executor what may go on.
  void take(Executor& ex);
  /// After a block that ended what take() is for.
  void close_intake(Executor& ex);

  std::int64_t d_number = 0;  ///< D in force (mill)

 private:
  using Entry = PipelineEntry;
  using EntryPtr = std::unique_ptr<Entry>;
  struct Corner39 {
    bool asked = false, has_direction = false;
    comp::Point direction;
  };

  EntryPtr fresh();
  void recycle(EntryPtr&& entry);
  void describe(const Executor& ex, Entry& entry);
  // stage 1 (pipeline.cpp)
  void corners(Executor& ex, EntryPtr&& entry);
  void meet_corner(Executor& ex, EntryPtr&& next);
  // stage 2 (pipeline_compensation.cpp)
  void compensate(Executor& ex, EntryPtr&& entry);
  void quiet_block(Executor& ex);
  void follow(Executor& ex, EntryPtr&& entry);
  void leave(Executor& ex, EntryPtr&& entry);
  enum class Closed : std::uint8_t { good, stopped, left_out };
  /// @param next the motion behind the corner; nullptr: none is known
  Closed close_last(Executor& ex, comp::Vectors& end, const Entry* next);
  Closed leave_out(Executor& ex, const Entry& next);
  // type C (pipeline_in_place.cpp)
  bool in_place() const { return settings_.type_c; }
  void step_onto_vector(Executor& ex, const Entry& entry);
  void step_off_vector(Executor& ex);
  /// @param next its feed is that of the corner's moves; nullptr: that of the block itself
  void release_previous(Executor& ex, const Entry* next);
  void settle_here(Executor& ex);
  void abandon(Executor& ex);
  void send_displaced(Executor& ex, EntryPtr&& entry);
  void send_entry(Executor& ex, EntryPtr&& entry);
  void displace(const Executor& ex, Motion& motion, const CompensationMode& mode, comp::Point by) const;
  void send_corner(Executor& ex, const Entry& block, const comp::Vectors& vectors);
  /// What parameters say about compensation: read once for each state of the machine data, by mode_of(), which stands
  /// at the head of take().
  struct Settings {
    bool read = false;
    std::uint64_t version = 0;
    comp::OffsetRules offset;
    bool diameter = false, type_c = false, checks_lines = false, checks_arcs = false, avoids = false;
    bool stops = false, one_value = false;
    double near_mm = 0;
    int read_ahead = 3;
  };
  void read_settings(const Executor& ex);

  void send(Executor& ex, Operation&& op);
  Operation& place(Executor& ex);
  void raise(Executor& ex, dialects::AlarmReason reason, const SourcePosition& at, std::uint32_t column,
             std::string detail);

  bool active_ = false;
  bool no_compensation_ = false;
  bool stopped_ = false;   ///< an alarm was raised here
  AxisVector position_{};  ///< end of the last motion read, as programmed
  std::vector<EntryPtr> incoming_, spare_;
  EntryPtr intake_;
  Operation* caller_ = nullptr;  ///< where Executor::out pointed before open_intake()

  Settings settings_;
  CompensationMode mode_;  ///< of the last block, and what it was made of:
  struct {
    bool read = false;
    Plane plane = Plane::xy;
    int first = 0, second = 0;
    int side = 0;
    bool again = false;
    std::int64_t number = 0;
    double value = 0;
    int tip = 0;
  } mode_from_;

  // the block being taken
  CornerRequest request_;
  bool block_counts_ = false;
  bool touch_ = false;
  bool lift_block_ = false;
  bool again_ = false;
  int side_ = 0;
  BlockVector vector_;
  Corner39 corner_arc_;

  // stage 1
  EntryPtr held_;
  bool held_corner_ = false;
  bool open_ = false;  ///< the held motion is a line whose end the next block gives
  double open_angle_deg_ = 0;
  int blocks_between_ = 0;
  std::vector<EntryPtr> corner_followers_;

  // stage 2
  bool on_ = false;
  bool has_previous_ = false, has_last_ = false;
  EntryPtr previous_, last_;
  comp::Vectors corner_;  ///< at the start of last_
  std::vector<EntryPtr> between_, after_;
  comp::Point kept_;  ///< vector the tool stands at when nothing is held
  CompensationMode kept_mode_;
  int quiet_blocks_ = 0;
  bool touched_ = false;

  // type C: G41/G42 and G40 in blocks without a move
  bool written_here_ = false;  ///< G40, G41 or G42 stands in this block
  bool starts_in_place_ = false;
  AxisVector passed_machine_{}, passed_work_{};  ///< programmed end of the motion before the last
  AxisVector coming_machine_{}, coming_work_{};  ///< programmed end of the last motion
  Operation passed_;                             ///< a copy of it
};

/// @return nullptr when it is no motion.
inline Motion* motion_in(Operation& operation) {
  if (auto* feed = std::get_if<Feed>(&operation)) return feed;
  if (auto* rapid = std::get_if<Rapid>(&operation)) return rapid;
  if (auto* arc = std::get_if<Arc>(&operation)) return arc;
  if (auto* thread = std::get_if<Thread>(&operation)) return thread;
  return std::get_if<Tap>(&operation);
}

}  // namespace headstock::interp
