// Offsets and other values as tables: what a page exports, what a person pastes from a spreadsheet or imports
// from a file. Reading changes nothing: it says, row by row, what would be written and what is wrong. Any
// thread.
//
//   # Headstock; profile fanuc-0i-t; unit mm; machine Lathe 1        (optional: then held against the
//   machine) number,X,X wear,Z,Z wear,R,R wear,tip                            tool offsets of a lathe
//   number,length,length wear,radius,radius wear                     … of a mill
//   system,X,Z                                                       work offsets: G54, G54.1P7, EXT, shift
//   what,value                                                       anything by its name
// Separated by tabs, commas or semicolons (the first line that has one decides). With tabs or semicolons a
// decimal comma is read too. An empty cell leaves the value as it is. Heads in Chinese are read too (序号
// 长度 半径 刀尖 …).
#pragma once

#include <string>
#include <vector>

#include "server/fleet/values.hpp"

namespace headstock::fleet {

struct SheetRow {
  std::int64_t line = 0;
  db::ValueItem item;  ///< before: as the machine has it now
  std::string
      problem;  ///< key of protocol/wire/reasons, or not_a_number, unknown_column; empty: it could be written
  std::string text;  ///< the cell, when there is a problem
};
struct Sheet {
  std::vector<SheetRow> rows;  ///< only values that differ, and problems
  std::int64_t values = 0;     ///< cells read
};
/// Refusals: bad_sheet (where: the line), other_profile, other_unit, too_large.
Sheet read_sheet(const MachinePages& pages, const std::string& text);

/// @param kind offsets work parameters variables tool_life, or empty: everything by name
std::string write_sheet(const MachinePages& pages, const db::MachineValues& values, const std::string& kind);

}  // namespace headstock::fleet
