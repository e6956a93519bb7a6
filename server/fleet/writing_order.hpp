// The order in which a machine takes values: parameters first (they decide what else there is), then offsets
// and variables, then tool life as its page is filled in: unit, life, tools one after the other, what is
// known of each tool, and at last the tools that are taken off, from the end. Any thread.
#pragma once

#include <string_view>
#include <vector>

#include "db/value_store.hpp"

namespace headstock::fleet {

/// A value of a tool life group by its name; group 0: it is none.
struct LifePlace {
  long group = 0;
  std::string_view field;  ///< "unit" "life" "current" "tool" "used" …
  long index = -1;         ///< of the tool; -1: of the group
};
LifePlace life_place(std::string_view what);

/// Names and values in the order of writing.
std::vector<std::pair<std::string, double>> in_writing_order(const db::MachineValues& values);
/// Sorts what is to be written; for equal places the order stays.
void put_in_writing_order(std::vector<db::ValueItem>& items);

}  // namespace headstock::fleet
