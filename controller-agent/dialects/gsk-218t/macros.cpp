// The variables of GSK218T (manual L2138-2541): behind addresses and in G65 H operations; no statements.
#include "macro/rules.hpp"

#include "dialects/build.hpp"
#include "interpreter/system_variables.hpp"

namespace headstock::dialects {
namespace {

using namespace interp::system_variables;
using interp::SystemVariable;

constexpr SystemVariable kVariables[] = {
    {1000, 1015, read_input, nullptr, 0},
    {1100, 1107, nullptr, write_output, 0},
};

macro::Rules make_rules() {
  macro::Rules r;
  r.locals = 0;
  r.common = {{{200, 231, false}, {500, 515, true}}};
  r.clear_volatile_parameter = "P013.1";  // RTMC
  r.single_block_parameter = "P013.0";    // SBKM
  r.most_brackets = 0;
  r.nine_is_indirect = true;  // #9200 is #[#200] (L2199)
  r.alarm_prefix = "";
  r.alarm_digits = 1;
  r.alarm_base = 400;
  r.alarm_most = 99;
  r.macro_calls = false;
  r.h_codes = true;
  return r;
}

}  // namespace

void add_gsk_218t_macros(Dialect& d) {
  static const macro::Rules rules = make_rules();
  d.macros = &rules;
  d.system_variables = kVariables;
}

}  // namespace headstock::dialects
