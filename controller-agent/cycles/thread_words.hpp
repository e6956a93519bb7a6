// Words that thread cycles share: lead, start angle, number of starts, run-out.
#pragma once

#include "cycles/single.hpp"
#include "cycles/turning_run.hpp"

namespace headstock::cycles {

enum class ThreadUse : std::uint8_t { single, multiple };

/// F or I, Q (start angle of a single pass), L, J, K, P where a control has them, into `job`, whose start,
/// end and taper are known. @return false after an alarm.
bool take_thread_words(interp::Executor& ex, const Rules& rules, const PlaneAxes& axes, ThreadUse use,
                       ThreadPass& job);

/// Keeps a thread for G192.
void remember_thread(interp::Executor& ex, const PlaneAxes& axes, const ThreadPass& job);

/// P and Q that count in least increments unless written with a point: mm.
/// @param unit_mm of a whole number; 0: as every length word.
double count_length(const interp::Executor& ex, const program::Word& word, double unit_mm);

}  // namespace headstock::cycles
