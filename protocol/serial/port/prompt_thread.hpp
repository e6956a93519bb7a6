// Scheduling of a thread that serves lines. Ten characters after a DC3 are 10 ms at 9,600 baud and 0.9 ms at
// 115,200: a thread that has to wait for its turn behind others' work neither stops in time nor keeps the
// line busy.
#pragma once

namespace headstock::serial {

/// Lets the calling thread run before all ordinary work (SCHED_RR, lowest priority), where the system permits
/// it (root, CAP_SYS_NICE or an RTPRIO limit of 1). Processes started from it are ordinary ones.
/// @return false: not permitted; lines work, and what a loaded machine costs them is counted as starved and
/// as characters behind a stop.
bool serve_promptly();

}  // namespace headstock::serial
