#include "interpreter/modal_memory.hpp"

#include <array>

#include "interpreter/executor.hpp"

namespace headstock::interp {

/// The whole modal state of an Executor, as far as blocks change it. Positions are not part of it: they are
/// where the axes stand.
struct KeptModes {
  std::uint32_t block = 0;  ///< number of the block before which it was so
  std::size_t axis_count = 0;
  std::array<ProgramAxis, kMaxAxes> axes{};
  ModalSnapshot modal;
  const GCode* motion_code = nullptr;
  bool incremental = false, exact_stop_mode = false, constant_surface_speed = false;
  FeedUnit feed_unit = FeedUnit::mm_per_minute;
  bool work_is_extra = false;
  std::size_t work_index = 0;
  Plane plane = Plane::xy;
  Executor::PlaneIndex plane_index;
  bool roles_given = false;
  std::array<std::int8_t, kMaxAxes> given_roles{};
  CuttingMode cutting_mode = CuttingMode::cutting;
  Transform transform;
  PolarCommand polar;
  SurfaceMode surface;
  ToolOffsetState tool_offset;
  bool one_digit_rapid = false;
  AxisVector increment_limit{};
  double unit_mm = 1;
  std::int64_t linear_increment = 0;
  double feed_mm = -1, lead_mm = 0, rpm = 0, surface_speed = 0, clamp_rpm = 0;
  int surface_axis = -1;
  int length_sign = 0;
  std::int64_t length_offset = 0, d_number = 0;
  // what cycles keep beyond RESET
  LastThread last_thread;
  double runout_tenths = -1;
  std::int32_t driven_m = 0;
  std::unique_ptr<OwnModes> own;  ///< of the dialect's language
};

namespace {

using program::letters;

// F alone is looked at by its value, axis words and the words of an arc change nothing that stays.
constexpr std::uint32_t kPassing = letters("ABCXYZUVWIJKRFNO");

enum class Change : std::uint8_t { nothing, motion_code, anything };

// G00 to G03: nothing of them stays but the code itself.
bool plain_motion(std::int32_t tenths) {
  return tenths == 0 || tenths == 10 || tenths == 20 || tenths == 30;
}

Change may_change(const Executor& ex) {
  const program::Block& b = ex.block;
  if (b.m_count != 0 || b.g_count > 1 || (b.words & ~kPassing) != 0) return Change::anything;
  if (ex.pending_axes != 0) return Change::anything;  // an offset is taken up on the way
  if (ex.motion_code->cycle || (b.marked != 0 && ex.own != nullptr)) return Change::anything;
  if (b.has('F') && ex.feed_value(b['F']) != ex.modal.feed) return Change::anything;
  if (b.g_count == 0 || b.g[0].tenths == ex.motion_code->tenths) return Change::nothing;
  const bool plain = plain_motion(b.g[0].tenths) && plain_motion(ex.motion_code->tenths) && ex.own == nullptr;
  return plain ? Change::motion_code : Change::anything;
}

// Each member of the one to the same of the other: written once for both directions.
template <typename From, typename To>
void copy_modes(const From& from, To& to) {
  to.modal = from.modal;
  to.motion_code = from.motion_code;
  to.incremental = from.incremental;
  to.exact_stop_mode = from.exact_stop_mode;
  to.constant_surface_speed = from.constant_surface_speed;
  to.feed_unit = from.feed_unit;
  to.work_is_extra = from.work_is_extra;
  to.work_index = from.work_index;
  to.plane = from.plane;
  to.plane_index = from.plane_index;
  to.roles_given = from.roles_given;
  to.given_roles = from.given_roles;
  to.cutting_mode = from.cutting_mode;
  to.transform = from.transform;
  to.polar = from.polar;
  to.surface = from.surface;
  to.tool_offset = from.tool_offset;
  to.one_digit_rapid = from.one_digit_rapid;
  to.increment_limit = from.increment_limit;
  to.unit_mm = from.unit_mm;
  to.linear_increment = from.linear_increment;
  to.feed_mm = from.feed_mm;
  to.lead_mm = from.lead_mm;
  to.rpm = from.rpm;
  to.surface_speed = from.surface_speed;
  to.clamp_rpm = from.clamp_rpm;
  to.surface_axis = from.surface_axis;
  to.length_sign = from.length_sign;
  to.length_offset = from.length_offset;
}

}  // namespace

ModalMemory::ModalMemory() = default;
ModalMemory::~ModalMemory() = default;

void ModalMemory::forget() {
  begin_ = count_ = whole_begin_ = whole_count_ = 0;
  open_ = failed_ = 0;
  held_ = false;
}

void ModalMemory::before_block(const Executor& ex) {
  if (held_) return;
  open_ = ex.at.block + 1;
  const Change change = may_change(ex);
  if (change == Change::nothing) return;
  Entry& entry = add(open_);
  entry.motion_code = ex.motion_code;
  entry.g = ex.modal.g;
  entry.whole = change == Change::anything;
  if (entry.whole) keep(ex);
}

// The oldest one makes room.
ModalMemory::Entry& ModalMemory::add(std::uint32_t block) {
  if (count_ == kMost) {
    if (entries_[begin_].whole) {
      whole_begin_ = (whole_begin_ + 1) % kMost;
      --whole_count_;
    }
    begin_ = (begin_ + 1) % kMost;
    --count_;
  }
  const std::size_t place = (begin_ + count_++) % kMost;
  if (place == entries_.size()) entries_.emplace_back();
  entries_[place].block = block;
  return entries_[place];
}

void ModalMemory::keep(const Executor& ex) {
  const std::size_t place = (whole_begin_ + whole_count_++) % kMost;
  if (place == whole_.size()) whole_.emplace_back();
  KeptModes& now = whole_[place];
  now.block = open_;
  now.axis_count = ex.axes.size();
  for (std::size_t i = 0; i < ex.axes.size(); ++i) now.axes[i] = ex.axes[i];
  copy_modes(ex, now);
  now.d_number = ex.pipeline.d_number;
  now.last_thread = ex.cycle.last_thread;
  now.runout_tenths = ex.cycle.runout_tenths;
  now.driven_m = ex.cycle.driven_m;
  if (ex.own == nullptr) return;
  if (now.own == nullptr) now.own = ex.own->make_modes();
  if (now.own != nullptr) ex.own->keep_modes(*now.own);
}

namespace {

/// How many of a ring's states, the oldest first, belong to blocks before this one.
template <typename State>
std::size_t older_than(std::uint32_t block, const std::vector<State>& ring, std::size_t begin,
                       std::size_t count) {
  std::size_t low = 0, high = count;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (ring[(begin + middle) % ModalMemory::kMost].block < block) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

void put_back(const KeptModes& then, Executor& ex) {
  copy_modes(then, ex);
  for (std::size_t i = 0; i < ex.axes.size() && i < then.axis_count; ++i) ex.axes[i] = then.axes[i];
  ex.pipeline.d_number = then.d_number;
  ex.cycle.last_thread = then.last_thread;
  ex.cycle.runout_tenths = then.runout_tenths;
  ex.cycle.driven_m = then.driven_m;
  if (then.own != nullptr) ex.own->restore_modes(*then.own);
}

}  // namespace

void ModalMemory::back_to(Executor& ex, std::uint32_t block) {
  // The oldest state that is not older than the block: between the two nothing was changed.
  const std::size_t first = older_than(block, entries_, begin_, count_);
  if (first == count_) return;
  const std::size_t whole = older_than(block, whole_, whole_begin_, whole_count_);
  if (whole < whole_count_) put_back(whole_[(whole_begin_ + whole) % kMost], ex);
  const Entry& then = entries_[(begin_ + first) % kMost];
  ex.motion_code = then.motion_code;
  ex.modal.g = then.g;
  ex.update_zeros();
  forget();
}

}  // namespace headstock::interp
