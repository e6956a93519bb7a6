// G65 H…: arithmetic and branches of the GSK lathes (218T L2260-2479, 2000TC L5277-5525).
#pragma once

#include <cstdint>
#include <span>

namespace headstock::interp {
struct Executor;
}

namespace headstock::dialects::gsk {

/// G65 H as 218T has it: whole quotients, no roots and no trigonometry.
bool run_h_code_218t(interp::Executor& ex);
/// G65 H as 2000TC has it.
bool run_h_code_2000tc(interp::Executor& ex);

}  // namespace headstock::dialects::gsk
