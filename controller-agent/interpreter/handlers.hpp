// The handlers of G codes that several dialects share, and their names in gcodes.tsv.
#pragma once

#include <string_view>

#include "dialects/dialect.hpp"

namespace headstock::interp::handlers {

/// What gcodes.tsv means by a handler's name.
struct Named {
  std::string_view name;
  dialects::Phase phase;
  dialects::Handler handler;  ///< nullptr: the code only changes the modal display
};

/// @return nullptr when there is no such handler.
const Named* find(std::string_view name);

bool set_coordinates(Executor& ex);  // G50, G92
bool thread(Executor& ex);           // G32, G33
bool thread_variable(Executor& ex);  // G34
bool contour_by_q(Executor& ex);     // G05.1
bool length_offset(Executor& ex);    // G43 G44 G49
bool tool_step(Executor& ex);        // G45-G48 (tool_step.cpp)
bool measure(Executor& ex);          // G36 G37 (measure.cpp)

}  // namespace headstock::interp::handlers
