// The handlers of canned cycles and their names in gcodes.tsv.
#pragma once

#include <string_view>

#include "dialects/dialect.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::cycles {

/// What gcodes.tsv means by a cycle's name. @return nullptr when there is no such cycle.
const interp::handlers::Named* find(std::string_view name);

// stock_removal.cpp
bool stock_removal_turning(interp::Executor& ex);  // G71
bool stock_removal_facing(interp::Executor& ex);   // G72
bool pattern_repeating(interp::Executor& ex);      // G73
bool finishing(interp::Executor& ex);              // G70
// single_cycles.cpp
bool turning_box(interp::Executor& ex);   // G90
bool thread_box(interp::Executor& ex);    // G92
bool facing_box(interp::Executor& ex);    // G94
bool face_pecking(interp::Executor& ex);  // G74
bool side_pecking(interp::Executor& ex);  // G75
// threading_cycle.cpp
bool multiple_threading(interp::Executor& ex);  // G76
bool thread_again(interp::Executor& ex);        // G192
// hole_cycles.cpp
bool hole_cycle(interp::Executor& ex);
bool hole_cancel(interp::Executor& ex);
// tapping.cpp
bool tapping(interp::Executor& ex);

/// Whether F of the cycle is a lead.
bool f_is_lead(dialects::Handler handler);

}  // namespace headstock::cycles
