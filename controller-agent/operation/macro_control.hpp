// What #3003 and #3004 take away from the operator's keys (0i-D 16.1), from ModalSnapshot::macro_control.
#pragma once

#include <cstdint>

namespace headstock::operation {

struct MacroControl {
  explicit MacroControl(std::uint32_t bits)
      : no_single_block((bits & 1u) != 0),
        no_wait((bits & 2u) != 0),
        no_hold((bits & 0x10u) != 0),
        no_override((bits & 0x20u) != 0),
        no_exact_stop((bits & 0x40u) != 0) {}
  bool no_single_block;  ///< #3003 bit 0
  bool no_wait;          ///< #3003 bit 1: the end of M, S, T functions is not waited for
  bool no_hold;          ///< #3004 bit 0
  bool no_override;      ///< #3004 bit 1: 100 %
  bool no_exact_stop;    ///< #3004 bit 2: exact stop check of cutting moves
};

}  // namespace headstock::operation
