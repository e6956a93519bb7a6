// Turns the moves of a turning cycle into canonical operations, one by one.
#pragma once

#include <optional>

#include "cycles/move.hpp"
#include "cycles/profile.hpp"
#include "cycles/rules.hpp"
#include "interpreter/executor.hpp"

namespace headstock::cycles {

/// Starts a cycle: its moves are made before the next block is read.
/// @param name what the motion records say: "G71"; static storage.
void start(interp::Executor& ex, const char* name, const PlaneAxes& axes, Moves moves,
           Stops stops = Stops::whole);

/// The tool's place in the plane, slide mm from the work zero.
Point here(const interp::Executor& ex, const PlaneAxes& axes);

/// The feed a cutting move of the cycle runs at. @return false after the alarm for a missing F.
bool check_feed(interp::Executor& ex);

/// A length word in slide mm: diameter words of a diameter axis become radii.
double slide_word(const interp::Executor& ex, const program::Word& word, std::size_t axis);
/// Target of an axis in this block, X or U; nothing when neither is written.
std::optional<double> target_word(const interp::Executor& ex, std::size_t axis, char absolute, char step);

/// A value that a cycle keeps: written to its parameter and reported.
void keep(interp::Executor& ex, std::string_view parameter, double value);

}  // namespace headstock::cycles
