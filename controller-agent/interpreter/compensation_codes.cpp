// G40 G41 G42 and G39: what they say to the pipeline, which does the work.
#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp {

// D: the offset number of G41/G42 on a mill; in force until the next one.
bool Executor::take_d() {
  const std::uint32_t column = block['D'].column;
  std::int64_t number = whole('D', AlarmReason::offset_number);
  if (number < 0 || !tool_life::take_offset(*this, 'D', number, column)) return false;
  if (number > tool_offset::most(*this)) return alarm(AlarmReason::offset_number, column, "D");
  pipeline.d_number = number;
  return true;
}

// I J K as a direction in the plane, as the slides see it: mirrored, scaled and turned like the contour.
comp::Point Executor::direction_words() const {
  constexpr char kLetters[3][2] = {{'I', 'J'}, {'K', 'I'}, {'J', 'K'}};
  const auto part = [this](char letter) { return block.has(letter) ? length_mm(block[letter]) : 0; };
  const auto& letters = kLetters[static_cast<std::size_t>(plane)];
  const comp::Point written{part(letters[0]), part(letters[1])};
  const PlaneIndex axes_of_plane = plane_axes();
  if (!transform.active() || axes_of_plane.first < 0 || axes_of_plane.second < 0) return written;
  const auto u = static_cast<std::size_t>(axes_of_plane.first),
             v = static_cast<std::size_t>(axes_of_plane.second);
  AxisVector tip{};
  tip[u] = written.u;
  tip[v] = written.v;
  const AxisVector turned = transform.turn(tip);
  return {turned[u], turned[v]};
}

// I J K of a straight move under G41/G42, or with the G40 that ends it. They leave the block's words.
void Executor::take_vector_words() {
  using comp::VectorWords;
  const VectorWords rule = dialect.compensation.vector_words;
  const bool cancels = pipeline.cancels_here();
  const bool mean =
      rule == VectorWords::all ? cancels || pipeline.side() != 0 : rule == VectorWords::cancel && cancels;
  if (!mean || (block.words & axis_letters) == 0) return;
  const comp::Point direction = direction_words();
  if (comp::length(direction) > 0) pipeline.vector(direction);
  block.words &= ~program::letters("IJK");
}

}  // namespace headstock::interp

namespace headstock::interp::handlers {
namespace {

bool side(Executor& ex, int wanted) {
  const auto& rules = ex.dialect.compensation;
  const bool off = ex.data.bit(rules.off_parameter) ||
                   (!rules.enable_parameter.empty() && ex.data.parameter(rules.enable_parameter, 1) == 0);
  if (off && wanted != 0)
    return ex.alarm(AlarmReason::g_unavailable, ex.code_column, std::string(ex.code->name));
  if (wanted != 0 && ex.switches.origin == ProgramOrigin::mdi && ex.data.bit(rules.mdi_alarm_parameter))
    return ex.alarm(AlarmReason::mdi_compensation, ex.code_column, std::string(ex.code->name));
  // G41 or G42 once more in the block of an arc; where nothing is compensated yet the start-up rule refuses
  // it.
  const bool arc = ex.motion_code->tenths == 20 || ex.motion_code->tenths == 30;
  const bool own_number = ex.dialect.alarm_code(AlarmReason::compensation_arc_again) !=
                          ex.dialect.alarm_code(AlarmReason::compensation_start_arc);
  if (wanted != 0 && arc && own_number && ex.pipeline.compensating() &&
      (ex.block.words & ex.axis_letters) != 0)
    return ex.alarm(AlarmReason::compensation_arc_again, ex.code_column, std::string(ex.code->name));
  const bool same = wanted != 0 && ex.pipeline.side() == wanted;
  if (wanted != 0) ex.pipeline.activate(ex.machine_now, ex.work_now);
  ex.pipeline.written(wanted, same);
  return true;
}

}  // namespace

bool compensation_cancel(Executor& ex) {
  return side(ex, 0);
}
bool compensation_left(Executor& ex) {
  return side(ex, 1);
}
bool compensation_right(Executor& ex) {
  return side(ex, -1);
}

// G39 [I_ J_ | I_ K_ | J_ K_]: a circle about the corner, to the normal of the next block or of the vector.
bool corner_arc(Executor& ex) {
  if ((ex.block.words & ex.axis_letters) != 0) {
    return ex.alarm(AlarmReason::corner_arc_with_move, ex.code_column, "G39");
  }
  const comp::Point direction = ex.direction_words();
  const double size = comp::length(direction);
  ex.pipeline.corner_arc(size > 0, size > 0 ? direction * (1 / size) : comp::Point{});
  return true;
}

}  // namespace headstock::interp::handlers
