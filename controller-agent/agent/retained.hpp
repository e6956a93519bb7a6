// What an agent remembers over a restart, as the values it keeps in the spool beside the events: counts and overrides,
// the selected program, offsets, parameters and common variables.
#pragma once

#include <string>

#include "interpreter/machine_data.hpp"
#include "link/spool.hpp"
#include "machine/machine.hpp"
#include "operation/controller.hpp"

namespace headstock::agent {

struct SelectedProgram {
  std::string name;     ///< empty: none
  std::string sha256;
};

link::RetainedValue counters_value(const operation::Retained& retained);
link::RetainedValue selected_value(const SelectedProgram& selected);
/// Offsets, parameters and common variables, as one text.
link::RetainedValue data_value(interp::MachineData data, const machine::Machine& machine);

/// Each throws std::runtime_error when the stored text is not understood: a machine must not start with half its offsets.
operation::Retained read_counters(const link::Spool& spool);
SelectedProgram read_selected(const link::Spool& spool);
/// Variables that do not outlive the power of the control (#100 to #199) are on the disk too, for what is reported.
enum class Variables : bool { kept, all };
interp::MachineData read_data(const link::Spool& spool, const machine::Machine& machine,
                              Variables which = Variables::kept);
/// After power on, before anything is reported: what the control has set or let go of by itself (variables
/// that do not outlive power, or begin as 0) is on the disk, and is told as a change of origin "power_on". A
/// disk that had no data yet has nothing to differ from.
void store_power_on(link::Spool& spool, const interp::MachineData& now, const machine::Machine& machine);

}  // namespace headstock::agent
