#include "protocol/serial/port/prompt_thread.hpp"

#include <sched.h>

namespace headstock::serial {

bool serve_promptly() {
  sched_param param{};
  param.sched_priority = ::sched_get_priority_min(SCHED_RR);
  return ::sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &param) == 0;
}

}  // namespace headstock::serial
