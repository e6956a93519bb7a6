// The machine of a check, put together from its records. Private to library/; worker.
#pragma once

#include <memory>
#include <string>

#include "interpreter/machine_data.hpp"
#include "machine/machine.hpp"
#include "operation/timing.hpp"
#include "program/source.hpp"
#include "server/library/checks.hpp"

namespace headstock::library {

struct Setup {
  machine::Machine machine;
  interp::MachineData data;
  std::shared_ptr<program::Programs> neighbours;  ///< the folder's other programs
  operation::OpenProgram open;
};

/// @return what is wrong with the machine's own description, empty when it can be used.
std::string set_up(const CheckJob& job, Setup& setup);

}  // namespace headstock::library
