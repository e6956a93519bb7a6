// G10: offsets written by the program. Every write is reported, so that it is stored.
#include <bit>

#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp::handlers {
namespace {

// A value as the offset page shows it: mm, diameter on a diameter axis.
double page_value(const Executor& ex, const program::Word& word, std::size_t axis) {
  const auto& a = ex.axes[axis];
  return static_cast<double>(ex.round_to(ex.nano(word, a.increment), a.increment)) / 1e9 *
         (a.rotary ? 1 : ex.unit_mm);
}

void write(Executor& ex, double& cell, double value, const std::string& what) {
  const double before = cell;
  cell = value;
  if (before != value) ex.report_change(what, before, value);
}

template <typename Cell>
bool write_axis_words(Executor& ex, const std::string& what, const Cell& cell_of) {
  for (std::uint32_t mask = ex.block.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    const auto axis = static_cast<std::size_t>(ex.axis_of[letter]);
    const bool by = ex.incremental || (ex.incremental_letters >> letter & 1u) != 0;
    double& cell = cell_of(axis);
    write(ex, cell, page_value(ex, ex.block.word[letter], axis) + (by ? cell : 0), what + ex.axes[axis].name);
  }
  return true;
}

ToolOffset* tool_offset(Executor& ex, std::int64_t number) {
  if (number < 1 || number > static_cast<std::int64_t>(ex.dialect.tools.most_offsets)) {
    ex.alarm(AlarmReason::data_input, ex.block['P'].column, "P" + std::to_string(number));
    return nullptr;
  }
  if (ex.data.tools.size() <= static_cast<std::size_t>(number)) {
    ex.data.tools.resize(static_cast<std::size_t>(number) + 1);
  }
  return &ex.data.tools[static_cast<std::size_t>(number)];
}

bool work_offset(Executor& ex, std::int64_t p) {
  const std::int64_t system = p - ex.dialect.first_g10_work;
  if (ex.dialect.first_g10_work == 1 && p == 0) {
    write_axis_words(ex, "work/EXT/", [&](std::size_t i) -> double& { return ex.data.work_external[i]; });
  } else if (system >= 0 && system < 6) {
    auto& zero = ex.data.work[static_cast<std::size_t>(system)];
    write_axis_words(ex, "work/G" + std::to_string(54 + system) + "/",
                     [&](std::size_t i) -> double& { return zero[i]; });
  } else {
    return ex.alarm(AlarmReason::data_input, ex.block['P'].column, "P" + std::to_string(p));
  }
  ex.update_zeros();
  return true;
}

bool work_extra_offset(Executor& ex, std::int64_t p) {
  if (p < 1 || p > 48)
    return ex.alarm(AlarmReason::data_input, ex.block['P'].column, "P" + std::to_string(p));
  auto& zero = ex.data.work_extra[static_cast<std::size_t>(p - 1)];
  write_axis_words(ex, "work/G54.1P" + std::to_string(p) + "/",
                   [&](std::size_t i) -> double& { return zero[i]; });
  ex.update_zeros();
  return true;
}

// Mill: L10/L11 length geometry and wear, L12/L13 radius geometry and wear, value in R.
bool mill_tool(Executor& ex, std::int64_t l, std::int64_t p) {
  ToolOffset* tool = tool_offset(ex, p);
  if (tool == nullptr) return false;
  const auto z = ex.axis_named('Z');
  if (!ex.block.has('R') || !z) return ex.alarm(AlarmReason::data_input, ex.code_column, "R");
  const std::string place = "tool/" + std::to_string(p) + "/";
  double* cell = &tool->geometry[*z];
  std::string what = place + "geometry/Z";
  if (l == 11 || l == 1) {
    cell = &tool->wear[*z];
    what = place + "wear/Z";
  } else if (l == 12) {
    cell = &tool->radius;
    what = place + "radius";
  } else if (l == 13) {
    cell = &tool->radius_wear;
    what = place + "radius_wear";
  }
  const double value = ex.length_mm(ex.block['R']);
  write(ex, *cell, value + (ex.incremental ? *cell : 0), what);
  return true;
}

// Lathe: G10 P n is wear offset n, P 10000+n geometry offset n (0i-D T, K2000TC with wear offsets).
bool lathe_tool(Executor& ex, std::int64_t p) {
  if (p == 0) {
    write_axis_words(ex, "work/shift/", [&](std::size_t i) -> double& { return ex.data.work_shift[i]; });
    ex.update_zeros();
    return true;
  }
  const bool geometry = p >= 10'000;
  const std::int64_t number = geometry ? p - 10'000 : p;
  ToolOffset* tool = tool_offset(ex, number);
  if (tool == nullptr) return false;
  const std::string place = "tool/" + std::to_string(number) + (geometry ? "/geometry/" : "/wear/");
  write_axis_words(ex, place,
                   [&](std::size_t i) -> double& { return geometry ? tool->geometry[i] : tool->wear[i]; });
  const std::string radius = "tool/" + std::to_string(number) + (geometry ? "/radius" : "/radius_wear");
  if (ex.block.has('R'))
    write(ex, geometry ? tool->radius : tool->radius_wear, ex.length_mm(ex.block['R']), radius);
  if (ex.block.has('Q')) {
    const std::int64_t tip = ex.whole('Q', AlarmReason::data_value);
    if (tip < 0) return false;
    if (tip > 9) return ex.alarm(AlarmReason::data_value, ex.block['Q'].column, "Q");
    const int before = tool->tip;
    tool->tip = static_cast<int>(tip);
    if (before != tool->tip) ex.report_change("tool/" + std::to_string(number) + "/tip", before, tool->tip);
  }
  return true;
}

}  // namespace

bool data_input(Executor& ex) {
  const program::Block& b = ex.block;
  const bool lathe = ex.dialect.tools.lathe;
  std::int64_t l = lathe ? 10 : -1;
  if (b.has('L')) {
    l = ex.whole('L', AlarmReason::data_input);
    if (l < 0) return false;
  }
  if (!b.has('P')) return ex.alarm(AlarmReason::data_input, ex.code_column, "P");
  const std::int64_t p = ex.whole('P', AlarmReason::data_input);
  if (p < 0) return false;
  if (l == 2 || (l == 1 && lathe)) return work_offset(ex, p);
  if (l == 20 && ex.table->find(541) != nullptr) return work_extra_offset(ex, p);
  if (lathe && l == 10) return lathe_tool(ex, p);
  if (!lathe && (l == 1 || (l >= 10 && l <= 13))) return mill_tool(ex, l, p);
  return ex.alarm(AlarmReason::g_unavailable, b.has('L') ? b['L'].column : ex.code_column,
                  "G10 L" + std::to_string(l));
}

}  // namespace headstock::interp::handlers
