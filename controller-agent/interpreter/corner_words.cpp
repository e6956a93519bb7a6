// The words of a block that say what happens at its corner: chamfers, rounds, angles of drawing dimensions.
#include <bit>
#include <cmath>

#include "compensation/drawing.hpp"
#include "interpreter/executor.hpp"

namespace headstock::interp {
namespace {

using comp::CornerShape;
using comp::Point;
using program::letters;

constexpr std::int16_t kG00 = 0, kG01 = 10, kG02 = 20, kG03 = 30;

std::string as_written(char letter, bool marked) {
  return marked ? std::string{',', letter} : std::string(1, letter);
}

}  // namespace

bool Executor::take_corner_words() {
  const auto& rules = dialect.corners;
  const std::int16_t mode = action != nullptr ? std::int16_t{-1} : motion_code->tenths;
  const bool straight = mode == kG01;
  const bool round = mode == kG02 || mode == kG03;
  const bool line = (straight || mode == kG00) && cycle.hole.code == nullptr;
  if (line && (block.words & letters("IJK")) != 0) take_vector_words();
  // Where N marks letters (K2000TC) other codes have marked words of their own.
  if (!straight && !(round && rules.arcs) && rules.named_letters != 0) return true;
  std::uint32_t marked = block.marked;
  const bool bare = data.bit(rules.bare_parameter);
  if (marked != 0) {
    const auto letter = static_cast<char>('A' + std::countr_zero(marked));
    const std::uint32_t column = block.marked_at(letter).column;
    if (bare) return alarm(AlarmReason::corner_comma, column, as_written(letter, true));
    const bool thread = mode != -1 && std::string_view(motion_code->name).substr(0, 2) == "G3";
    if (thread) return alarm(AlarmReason::corner_thread, column, as_written(letter, true));
    if (!straight && !(round && rules.arcs)) {
      return alarm(AlarmReason::corner_comma, column, as_written(letter, true));
    }
  }
  if (!straight && !(round && rules.chamfer_word != 0)) return true;

  // Words without a mark that mean the same: they leave `words`, where they have other meanings.
  const auto take = [&](char letter, char as) {
    if (!block.has(letter)) return;
    block.words &= ~letter_bit(letter);
    block.marked |= letter_bit(as);
    block.marked_word[program::letter_index(as)] = block[letter];
  };
  if (bare) {
    for (const char letter : {'A', 'C', 'R'}) {
      if ((axis_letters & letter_bit(letter)) == 0) take(letter, letter);
    }
  }
  if (rules.chamfer_word != 0) take(rules.chamfer_word, 'C');
  if (rules.round_word != 0) take(rules.round_word, 'R');
  if (straight && data.bit(rules.round_r_parameter)) take('R', 'R');
  if (straight && data.bit(rules.chamfer_ijk_parameter)) {
    for (const char letter : {'I', 'J', 'K'}) take(letter, 'C');
  }
  marked = block.marked;

  CornerRequest request;
  const bool has_classic = rules.perpendicular_words && !bare && straight &&
                           (block.words & letters("IJKR")) != 0 && (block.words & axis_letters) != 0;
  if (const std::uint32_t left = block.words & dialect.corner_words & letters("IJKR");
      left != 0 && !has_classic && straight && (block.words & axis_letters) != 0 &&
      dialect.compensation.vector_words != comp::VectorWords::all) {
    // Neither a chamfer nor the vector of a G40.
    const auto letter = static_cast<char>('A' + std::countr_zero(left));
    return alarm(AlarmReason::corner_unavailable, block[letter].column, std::string("G01 ") + letter);
  }
  if (marked == 0 && !has_classic) return true;
  if (!rules.enable_parameter.empty() && data.parameter(rules.enable_parameter, 1) == 0) {
    return alarm(AlarmReason::corner_unavailable, 0, {});
  }
  pipeline.activate(machine_now, work_now);

  if (block.has_marked('C') && block.has_marked('R')) {
    return alarm(AlarmReason::corner_words, block.marked_at('R').column, "C R");
  }
  if (block.has_marked('C') || block.has_marked('R')) {
    const char letter = block.has_marked('C') ? 'C' : 'R';
    const program::Word& word = block.marked_at(letter);
    request.size_mm = length_mm(word);
    request.column = word.column;
    request.shape = letter == 'C' ? CornerShape::chamfer : CornerShape::round;
    const bool ignored =
        rules.ignored_above_mm > 0 && (request.size_mm < 0 || request.size_mm > rules.ignored_above_mm);
    if (request.size_mm < 0 && !ignored) {
      return alarm(AlarmReason::minus_sign, word.column, as_written(letter, true));
    }
    if (request.size_mm == 0 || ignored) request.shape = CornerShape::none;
  } else if (has_classic && !take_perpendicular(request)) {
    return false;
  }
  for (std::size_t k = 0; k < 2; ++k) {
    const CompensationMode now = pipeline.mode_of(*this);
    angle_from[k] = axes[k == 0 ? now.first : now.second].position;
  }
  if (block.has_marked('A')) {
    if (!straight) return alarm(AlarmReason::corner_comma, block.marked_at('A').column, ",A");
    if (!rules.angle_parameter.empty() && data.parameter(rules.angle_parameter, 1) == 0)
      return alarm(AlarmReason::corner_unavailable, block.marked_at('A').column, "A");
    if ((block.words & axis_letters) == 0) {
      if (pipeline.line_is_open()) {
        return alarm(AlarmReason::drawing_no_end, block.marked_at('A').column, ",A");
      }
      request.open = true;
      request.column = block.marked_at('A').column;
      request.angle_deg = angle_deg(block.marked_at('A'));
    }
  }
  pipeline.ask_corner(request);
  return !request.open || open_line();
}

bool Executor::drawing_allows_codes() {
  struct Refused {
    std::int16_t tenths;
    AlarmReason reason;
  };
  constexpr Refused kRefused[] = {{170, AlarmReason::drawing_plane},  {180, AlarmReason::drawing_plane},
                                  {190, AlarmReason::drawing_plane},  {200, AlarmReason::drawing_unit},
                                  {210, AlarmReason::drawing_unit},   {121, AlarmReason::drawing_polar},
                                  {131, AlarmReason::drawing_polar},  {1120, AlarmReason::drawing_polar},
                                  {1130, AlarmReason::drawing_polar}, {511, AlarmReason::drawing_mirror},
                                  {501, AlarmReason::drawing_mirror}, {680, AlarmReason::drawing_mirror},
                                  {690, AlarmReason::drawing_mirror}};
  const bool open = pipeline.line_is_open();
  for (std::size_t i = 0; i < block.g_count; ++i) {
    for (const Refused& refused : kRefused) {
      // The first of the two blocks may choose its plane.
      if (refused.tenths != block.g[i].tenths || (!open && refused.reason == AlarmReason::drawing_plane))
        continue;
      return alarm(refused.reason, block.g[i], 'G');
    }
  }
  return true;
}

double Executor::angle_deg(const program::Word& word) const {
  return static_cast<double>(nano(word, program::kNano / 1000)) / 1e9;
}

// I J K R of G01 along one axis: the sign is that of the next block's move (0i-T).
bool Executor::take_perpendicular(CornerRequest& request) {
  const std::uint32_t written = block.words & letters("IJKR");
  const auto letter = static_cast<char>('A' + std::countr_zero(written));
  const program::Word& word = block[letter];
  if (std::popcount(written) > 1) return alarm(AlarmReason::corner_words, word.column, "I J K R");
  constexpr char kCenters[3][2] = {{'I', 'J'}, {'K', 'I'}, {'J', 'K'}};
  const CompensationMode now = pipeline.mode_of(*this);
  bool moves[2] = {false, false};
  for (std::uint32_t mask = block.words & axis_letters; mask != 0; mask &= mask - 1) {
    const auto axis = axis_of[static_cast<std::size_t>(std::countr_zero(mask))];
    if (axis == now.first) moves[0] = true;
    if (axis == now.second) moves[1] = true;
  }
  if (moves[0] == moves[1]) {
    return alarm(moves[0] ? AlarmReason::corner_taper : AlarmReason::corner_axis, word.column,
                 std::string(1, letter));
  }
  const std::size_t other = moves[0] ? 1 : 0;
  if (letter != 'R' && kCenters[static_cast<std::size_t>(plane)][other] != letter) {
    return alarm(AlarmReason::corner_axis, word.column, std::string(1, letter));
  }
  const double size = length_mm(word);
  if (size == 0) return true;
  request.shape = letter == 'R' ? CornerShape::round : CornerShape::chamfer;
  request.size_mm = std::fabs(size);
  request.column = word.column;
  request.perpendicular = true;
  request.next_is_second = other == 1;
  request.next_sign = size > 0 ? 1 : -1;
  block.words &= ~written;
  return true;
}

// A line whose end the next block gives: held in the pipeline until then.
bool Executor::open_line() {
  double value = 0;
  FeedUnit unit{};
  if (!cutting_feed(0, value, unit)) return false;
  auto& motion = emit<Feed>();
  fill_motion(motion, 0);
  motion.feed = value;
  motion.unit = unit;
  return true;
}

bool Executor::take_angle(std::uint32_t& moved) {
  if (pipeline.line_is_open() && !block.has_marked('A')) return true;  // refused when the move arrives
  if (!block.has_marked('A')) return true;
  const program::Word& word = block.marked_at('A');
  if (transform.active()) return alarm(AlarmReason::corner_comma, word.column, ",A");
  const CompensationMode now = pipeline.mode_of(*this);
  const std::size_t u = now.first, v = now.second;
  const double angle = angle_deg(word);
  const double parallel = dialect.corners.parallel_deg;
  const auto mm = [this](std::size_t axis, std::int64_t position) {
    return static_cast<double>(position) / 1e9 * axes[axis].mm_per_unit;
  };
  const auto to_nano = [this](std::size_t axis, double at_mm) {
    return round_to(std::llround(at_mm / axes[axis].mm_per_unit * 1e9), axes[axis].increment);
  };
  const Point from{mm(u, angle_from[0]), mm(v, angle_from[1])};
  const bool has_u = (moved >> u & 1u) != 0, has_v = (moved >> v & 1u) != 0;
  if (pipeline.line_is_open()) {
    if (!has_u || !has_v) return alarm(AlarmReason::drawing_no_end, word.column, ",A");
    if (incremental || (block.words & incremental_letters) != 0) {
      return alarm(AlarmReason::drawing_incremental, word.column, ",A");
    }
    const Point to{mm(u, axes[u].position), mm(v, axes[v].position)};
    const auto corner = comp::meet(from, pipeline.open_angle_deg(), to, angle, parallel);
    if (!corner) return alarm(AlarmReason::drawing_parallel, word.column, ",A");
    AxisVector slides = machine_now, page = work_now;
    const auto place = [&](std::size_t axis, double at_mm) {
      const std::int64_t position = to_nano(axis, at_mm);
      page[axis] = static_cast<double>(position) / 1e9;
      slides[axis] = to_machine(axis, position);
    };
    place(u, corner->u);
    place(v, corner->v);
    machine_now = slides;
    work_now = page;
    pipeline.close_line(slides, page, 1u << u | 1u << v);
    return true;
  }
  if (has_u && has_v) return alarm(AlarmReason::drawing_no_solution, word.column, ",A");
  const auto end = has_u ? comp::at_first(from, angle, mm(u, axes[u].position), parallel)
                         : comp::at_second(from, angle, mm(v, axes[v].position), parallel);
  if (!end) return alarm(AlarmReason::drawing_no_solution, word.column, ",A");
  if (has_u) axes[v].position = to_nano(v, end->v);
  if (has_v) axes[u].position = to_nano(u, end->u);
  moved |= 1u << u | 1u << v;
  return true;
}

}  // namespace headstock::interp
