#include "cycles/handlers.hpp"

#include <algorithm>
#include <iterator>

namespace headstock::cycles {
namespace {

using dialects::Phase;
using interp::handlers::Named;

constexpr Named kCycles[] = {
    {"finishing", Phase::action, finishing},
    {"stock_removal_turning", Phase::action, stock_removal_turning},
    {"stock_removal_facing", Phase::action, stock_removal_facing},
    {"pattern_repeating", Phase::action, pattern_repeating},
    {"turning_box", Phase::motion, turning_box},
    {"thread_box", Phase::motion, thread_box},
    {"facing_box", Phase::motion, facing_box},
    {"face_pecking", Phase::action, face_pecking},
    {"side_pecking", Phase::action, side_pecking},
    {"multiple_threading", Phase::action, multiple_threading},
    {"thread_again", Phase::action, thread_again},
    {"hole_cycle", Phase::hole, hole_cycle},
    {"hole_once", Phase::action, hole_cycle},
    {"hole_cancel", Phase::setting, hole_cancel},
    {"tapping", Phase::motion, tapping},
    {"tapping_once", Phase::action, tapping},
};

}  // namespace

const Named* find(std::string_view name) {
  const auto* found = std::find_if(std::begin(kCycles), std::end(kCycles),
                                   [name](const Named& named) { return named.name == name; });
  return found == std::end(kCycles) ? nullptr : found;
}

bool f_is_lead(dialects::Handler handler) {
  return handler == thread_box || handler == multiple_threading || handler == tapping;
}

}  // namespace headstock::cycles
