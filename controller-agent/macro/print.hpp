// The bytes of DPRNT and BPRNT (0i-D 14.8 L20009-20257).
#pragma once

#include <string>

#include "macro/compile.hpp"

namespace headstock::macro {

struct PrintFormat {
  bool plain = false;     ///< no spaces for leading zeros and the plus sign (PRT)
  bool cr_after_lf = false;  ///< (CRO)
};

/// Appends what the statement prints, the end of block included. `out` is unchanged when a value failed.
Result print(const Statement& statement, Variables& variables, const PrintFormat& format, std::string& out);

}  // namespace headstock::macro
