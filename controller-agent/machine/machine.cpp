#include "machine/machine.hpp"

#include <algorithm>

namespace headstock::machine {

std::optional<std::size_t> Machine::axis_index(char axis_name) const {
  const auto found =
      std::find_if(axes.begin(), axes.end(), [&](const Axis& axis) { return axis.name == axis_name; });
  if (found == axes.end()) return std::nullopt;
  return static_cast<std::size_t>(found - axes.begin());
}

}  // namespace headstock::machine
