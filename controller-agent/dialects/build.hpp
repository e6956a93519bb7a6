// How a dialect's folder turns its tables into a Dialect. Used at first look-up, once.
#pragma once

#include <array>
#include <initializer_list>
#include <span>
#include <string_view>
#include <utility>

#include "dialects/dialect.hpp"

namespace headstock::dialects {

/// One row of gcodes.tsv: A, B, C, group, power_on, handler, meaning, source.
using GRow = std::array<std::string_view, 8>;

/// A handler that only this dialect has.
struct OwnHandler {
  std::string_view name;
  Phase phase;
  Handler handler;
};

/// Fills the three systems. A row that names no known handler is a programming error and ends the program
/// with its text.
void add_g_codes(Dialect& dialect, std::span<const GRow> rows, std::span<const OwnHandler> own = {});

/// Sets the controller's numbers. @param otherwise is used for every reason not listed.
void set_alarm_codes(Dialect& dialect, std::string_view otherwise,
                     std::initializer_list<std::pair<AlarmReason, std::string_view>> codes);

/// What FANUC-like lathes share: M03…M05, M00…M02, M30, M98, M99.
std::vector<MRule> usual_m_rules();

/// Chamfers, drawing dimensions, radius compensation: data and alarm numbers of the profile (path_rules.cpp).
void set_path_rules(Dialect& dialect);
/// The macro language and variables of a dialect, and their alarm numbers. After `tools` and the other alarms.
void add_fanuc_macros(Dialect& dialect);
void add_gsk_2000tc_macros(Dialect& dialect);
void add_gsk_218t_macros(Dialect& dialect);

Dialect make_fanuc_0i_t();
Dialect make_fanuc_0i_m();
Dialect make_gsk_2000tc();
Dialect make_gsk_218t();
Dialect make_k2000tc();
Dialect make_lathe_200t();

}  // namespace headstock::dialects
