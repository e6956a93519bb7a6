// G10: tool offsets of the K2000TC (L18469); work offsets are common.
#include <bit>
#include <cmath>
#include <string>

#include "dialects/k2000tc/language.hpp"
#include "dialects/k2000tc/modes.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::dialects::k2000tc {
namespace {

constexpr double kMostGeometry_mm = 10'000, kMostRadius_mm = 100, kMostWear_mm = 10'000;

bool put(Executor& ex, double& cell, double value, double most, std::uint32_t column,
         const std::string& what) {
  if (std::fabs(value) > most) return ex.alarm(AlarmReason::data_value, column, what);
  const double before = cell;
  cell = value;
  if (before != value) ex.report_change(what, before, value);
  return true;
}

}  // namespace

// G10 [L10] P X Z R Q: with WOFC (P3200.0) P n is wear n and P 10000+n geometry n, otherwise P n is geometry
// n. U W add, NC adds to the radius, Q is the tip.
bool data_input(Executor& ex) {
  const auto& b = ex.block;
  std::int64_t l = 10;
  if (b.has('L')) l = ex.whole('L', AlarmReason::data_input);
  if (l < 0) return false;
  if (l != 10) return interp::handlers::data_input(ex);
  if (!b.has('P')) return ex.alarm(AlarmReason::data_input, ex.code_column, "P");
  std::int64_t number = ex.whole('P', AlarmReason::data_input);
  if (number < 0) return false;
  if (number == 0) return interp::handlers::data_input(ex);  // the work shift
  const bool has_wear = ex.data.bit("P3200.0");
  const bool geometry = !has_wear || number > 10'000;
  if (has_wear && geometry) number -= 10'000;
  if (number < 1 || number > static_cast<std::int64_t>(ex.dialect.tools.most_offsets))
    return ex.alarm(AlarmReason::data_input, b['P'].column, "P" + std::to_string(number));
  auto& tools = ex.data.tools;
  const auto row = static_cast<std::size_t>(number);
  if (tools.size() <= row) tools.resize(row + 1);
  const double most_wear = ex.data.parameter("P3220", kMostWear_mm);
  const std::string place = "tool/" + std::to_string(number) + (geometry ? "/geometry/" : "/wear/");
  for (std::uint32_t mask = b.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    const auto axis = static_cast<std::size_t>(ex.axis_of[letter]);
    const auto& a = ex.axes[axis];
    const bool by = ex.incremental || (ex.incremental_letters >> letter & 1u) != 0;
    const double slide = static_cast<double>(ex.round_to(ex.nano(b.word[letter], a.increment), a.increment)) /
                         1e9 * a.mm_per_unit;
    double& cell = geometry ? tools[row].geometry[axis] : tools[row].wear[axis];
    const double page = slide / (a.page_diameter != 0 ? a.page_diameter : a.diameter) + (by ? cell : 0);
    if (!put(ex, cell, page, geometry ? kMostGeometry_mm : most_wear, b.word[letter].column, place + a.name))
      return false;
  }
  double& nose = geometry ? tools[row].radius : tools[row].radius_wear;
  const std::string radius = "tool/" + std::to_string(number) + (geometry ? "/radius" : "/radius_wear");
  const double most_radius = geometry ? kMostRadius_mm : most_wear;
  if (b.has('R') &&
      !put(ex, nose, ex.length_mm(b['R']) + (ex.incremental ? nose : 0), most_radius, b['R'].column, radius))
    return false;
  if (b.has_marked('C') &&
      !put(ex, nose, nose + ex.length_mm(b.marked_at('C')), most_radius, b.marked_at('C').column, radius))
    return false;
  if (b.has('Q')) {
    const std::int64_t tip = ex.whole('Q', AlarmReason::data_value);
    if (tip < 0) return false;
    if (tip > 9) return ex.alarm(AlarmReason::data_value, b['Q'].column, "Q");
    const int before = tools[row].tip;
    tools[row].tip = static_cast<int>(tip);
    if (before != tip)
      ex.report_change("tool/" + std::to_string(number) + "/tip", before, static_cast<double>(tip));
  }
  return true;
}

}  // namespace headstock::dialects::k2000tc
