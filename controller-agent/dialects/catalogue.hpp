// What the controllers' manuals list: alarms, parameters, M codes, PMC/PLC signals and variables of each profile, as
// constants compiled in from dialects/<controller>/*.tsv. Look-ups allocate nothing; any thread may call them. Every
// view points into the program's constants and lives as long as the program.
#pragma once

#include <string_view>
#include <vector>

namespace headstock::dialects {

/// One alarm. `code` is what the controller prints ("PS0010", "OT0500", GSK: plain numbers).
struct Alarm {
  std::string_view code;
  std::string_view series;      ///< "T" or "M" when only that series has it, otherwise empty
  std::string_view en;          ///< short text as a screen would show it
  std::string_view zh;          ///< the same in Chinese
  std::string_view cause;       ///< what made it (English); may be empty
  std::string_view cleared_by;  ///< what clears it besides RESET, or empty
  std::string_view source;      ///< line of the manual, "L6617"; empty for Headstock's own
};

/// One parameter, or one bit of one ("1006#3").
struct Parameter {
  std::string_view number, series, symbol;
  std::string_view name_zh;     ///< short Chinese name, for lists
  std::string_view meaning, unit, range;
  std::string_view default_value;
  std::string_view effective;   ///< when a change takes effect
  std::string_view source;
};

struct MCode { std::string_view code, series, meaning, source; };
struct Signal { std::string_view address, symbol, direction, meaning, source; };
struct Variable { std::string_view number, access, meaning, source; };

/// The alarm with this code. User alarms of a range ("PS3000-3999") are found by any number in it.
/// @param found set to the row @return false when the profile or the code is unknown
bool find_alarm(std::string_view profile, std::string_view code, Alarm& found);

/// Never empty: a code that only the sister series has gives that text, an unknown one the code itself.
Alarm alarm_text(std::string_view profile, std::string_view code);

/// The parameter with this number, written as in `parameters()` ("1401#1").
bool find_parameter(std::string_view profile, std::string_view number, Parameter& found);

// Everything a profile has, in the order of the manual. Empty for an unknown profile.
std::vector<Alarm> alarms(std::string_view profile);
std::vector<Parameter> parameters(std::string_view profile);
std::vector<MCode> mcodes(std::string_view profile);
std::vector<Signal> signals(std::string_view profile);
std::vector<Variable> variables(std::string_view profile);

/// The six profiles of the offline tools' contract.
std::vector<std::string_view> profiles();

}  // namespace headstock::dialects
