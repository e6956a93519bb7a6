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
};

}  // namespace

const Named* find(std::string_view name) {
  const auto* found = std::find_if(std::begin(kCycles), std::end(kCycles),
                                   [name](const Named& named) { return named.name == name; });
  return found == std::end(kCycles) ? nullptr : found;
}

}  // namespace headstock::cycles
