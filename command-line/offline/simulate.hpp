// `headstock simulate`: a program run by the controller in virtual time.
#pragma once

namespace headstock::options {
class Command;
}

namespace headstock::offline {

/// Adds the sub-command; its callback leaves 0, 1 (bad usage or file) or 2 (an alarm) in `exit_status`.
void add_simulate(options::Command app, int& exit_status);

}  // namespace headstock::offline
