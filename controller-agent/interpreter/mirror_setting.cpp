#include "interpreter/mirror_setting.hpp"

#include <string>

#include "interpreter/executor.hpp"

namespace headstock::interp {

void Executor::take_mirror_setting() {
  const std::string_view number = dialect.modes.mirror_setting_parameter;
  if (number.empty()) return;
  std::uint32_t wanted = 0;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (data.parameter(std::string(number) + '/' + axes[i].name, data.parameter(number)) != 0)
      wanted |= 1u << i;
  if (wanted == mirror_setting.axes) return;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if ((wanted & ~mirror_setting.axes) >> i & 1u) mirror_setting.at[i] = machine_now[i];
  transform.mirrored = (transform.mirrored & ~mirror_setting.axes) | wanted;
  mirror_setting.axes = wanted;
  update_zeros();
}

/// The mirror stands still in machine coordinates; the transform counts from the work zero point.
void Executor::keep_mirror_place(std::size_t axis) {
  if ((mirror_setting.axes >> axis & 1u) != 0)
    transform.mirror_at[axis] = mirror_setting.at[axis] - modal.work_zero[axis];
}

}  // namespace headstock::interp
