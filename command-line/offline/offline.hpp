// The sub-commands of `headstock` that need no server. Each function adds one to the application; its callback leaves
// the exit status in `exit_status` (0 normal, 2 an alarm, 1 bad usage or file).
#pragma once

namespace headstock::options {
class Command;
}

namespace headstock::offline {

/// `headstock interpret`: canonical operations of a program as JSON Lines.
void add_interpret(options::Command app, int& exit_status);
/// `headstock check`: alarms of programs, one line each.
void add_check(options::Command app, int& exit_status);
/// `headstock plot`: a program's path as SVG.
void add_plot(options::Command app, int& exit_status);
/// `headstock profile`: what a controller's catalogue holds, and which codes are carried out.
void add_profile(options::Command app, int& exit_status);
/// `headstock convert-tape`: ISO, EIA and ASCII tape codes.
void add_convert_tape(options::Command app, int& exit_status);
/// `headstock dnc send|receive|test`: a serial line of this computer.
void add_dnc(options::Command app, int& exit_status);

}  // namespace headstock::offline
