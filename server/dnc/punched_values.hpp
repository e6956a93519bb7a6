// What a control has punched as machine data, under the names by which its pages know the values
// (controller-agent/interpreter/data_values.hpp). Any thread.
#pragma once

#include <cstdint>
#include <string_view>

#include "server/fleet/values.hpp"

namespace headstock::dnc {

struct PunchedValues {
  db::MachineValues values;
  std::int64_t not_read = 0;  ///< values of a form that only their own control can read; the set keeps them
};
/// Offsets, work offsets and macro variables as tape::named_values; parameters by the profile's own numbers
/// (an axis by its place, bits one by one, a length only with its decimal point: without one its unit is a
/// setting of the control); tool life by groups (FANUC: Q1 uses, Q2 minutes; without Q as bit 6800#2 says).
PunchedValues punched_values(const fleet::MachinePages& pages, std::string_view text);

}  // namespace headstock::dnc
