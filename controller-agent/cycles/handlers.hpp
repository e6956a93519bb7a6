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

}  // namespace headstock::cycles
