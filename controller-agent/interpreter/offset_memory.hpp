// What a mill's offset number means in the memory that the control has (0i-M: NGW, No.8136#6).
#pragma once

#include <cstdint>

namespace headstock::interp {

struct Executor;

namespace tool_offset {

/// Memory A, one value a number: the same number's value is a length behind H and a radius behind D; nothing
/// is wear.
bool one_value(const Executor& ex);
/// What H and D of an offset number mean [mm]; 0 for a number that has none.
double length_value(const Executor& ex, std::int64_t number);
double radius_value(const Executor& ex, std::int64_t number);

}  // namespace tool_offset
}  // namespace headstock::interp
