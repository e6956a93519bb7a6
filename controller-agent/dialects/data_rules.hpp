// What a controller lets a person write into its pages by hand (over the network too), and when: how many
// offset numbers it has, how large their values may be, what is locked, what has to stand still. The agent
// asks before it writes; the server asks the same before it sends, so that nobody waits for a refusal. Any
// thread.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "dialects/dialect.hpp"
#include "interpreter/data_values.hpp"

namespace headstock::dialects {

/// How the offset page of a machine looks.
struct OffsetPage {
  std::size_t numbers = 0;  ///< 1 … numbers
  bool lathe = false;
  char memory = 'C';      ///< mill: A one value a number, B geometry and wear, C length and radius apart
  bool wear = true;       ///< geometry and wear apart; otherwise one value, kept as geometry
  double largest_mm = 0;  ///< of a geometry value, both signs
  double largest_wear_mm = 0;
  int tips = 9;           ///< 0 … tips
  int extra_systems = 0;  ///< G54.1 P1 … ; 0: none
  int work_systems = 6;   ///< G54 … ; 0: the control has none
  std::uint32_t first_variable = 100, last_volatile = 199, first_kept = 500, last_kept = 999;
};
OffsetPage offset_page(const Dialect& dialect, const interp::MachineData& data);

/// The state of the machine that rules look at.
struct Situation {
  bool running = false;           ///< automatic operation, also held or stopped in it, or an axis is moving
  bool mdi_or_emergency = false;  ///< MDI mode, or emergency stop
  bool parameter_write = false;   ///< switched on by a person at the machine (PWE, parameter switch)
};

/// @return why the controller would not take this value now, as a key of protocol/wire/reasons; empty: it
/// would.
///   bad_place: it has no such value · out_of_range · locked: protected against input by its parameters ·
///   wear_step: larger than its largest single input of wear (GSK 2000TC P140) · running ·
///   parameter_write_off · not_mdi: neither in MDI mode nor in emergency stop
std::string refuse_value(const Dialect& dialect, const interp::MachineData& data,
                         const std::vector<char>& axis_names, std::string_view what,
                         std::optional<double> value, const Situation& situation);

/// The catalogue's range of a parameter as numbers; nothing when it is none ("see meaning").
struct NumberRange {
  double least = 0, most = 0;
};
std::optional<NumberRange> parameter_range(std::string_view text);

}  // namespace headstock::dialects
