// G28 of the 218T.
#pragma once

namespace headstock::interp {
struct Executor;
}

namespace headstock::dialects::gsk_218t {

/// With the coordinates that it may set (APRS, P006.6).
bool reference_return(interp::Executor& ex);

}  // namespace headstock::dialects::gsk_218t
