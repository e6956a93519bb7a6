// G10: offsets written by the program. Every write is reported, so that it is stored.
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "interpreter/data_values.hpp"
#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"
#include "interpreter/offset_memory.hpp"

namespace headstock::interp::handlers {

namespace {

// A value as the offset page shows it: mm, diameter on a diameter axis.
double page_value(const Executor& ex, const program::Word& word, std::size_t axis) {
  const auto& a = ex.axes[axis];
  return static_cast<double>(ex.round_to(ex.axis_value(word, a), a.increment)) / 1e9 *
         (a.rotary ? 1 : ex.unit_mm);
}

void write(Executor& ex, double& cell, double value, const std::string& what) {
  const double before = cell;
  cell = value;
  if (before != value) ex.report_change(what, before, value);
}

template <typename Cell>
bool write_axis_words(Executor& ex, const std::string& what, const Cell& cell_of,
                      std::uint32_t letters = ~0u) {
  for (std::uint32_t mask = ex.block.words & ex.axis_letters & letters; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<unsigned>(std::countr_zero(mask));
    const auto axis = static_cast<std::size_t>(ex.axis_of[letter]);
    const bool by = ex.incremental || (ex.incremental_letters >> letter & 1u) != 0;
    double& cell = cell_of(axis);
    const double value = page_value(ex, ex.block.word[letter], axis) + (by ? cell : 0);
    if (std::fabs(value) > ex.dialect.modes.largest_offset)
      return ex.alarm(AlarmReason::data_value, ex.block.word[letter].column,
                      std::string(1, static_cast<char>('A' + letter)));
    write(ex, cell, value, what + ex.axes[axis].name);
  }
  return true;
}

ToolOffset* tool_offset(Executor& ex, std::int64_t number) {
  if (number < 1 || number > static_cast<std::int64_t>(ex.dialect.tools.most_offsets)) {
    ex.alarm(AlarmReason::data_number, ex.block['P'].column, "P" + std::to_string(number));
    return nullptr;
  }
  if (ex.data.tools.size() <= static_cast<std::size_t>(number)) {
    ex.data.tools.resize(static_cast<std::size_t>(number) + 1);
  }
  return &ex.data.tools[static_cast<std::size_t>(number)];
}

bool work_offset(Executor& ex, std::int64_t p) {
  const std::int64_t system = p - ex.dialect.first_g10_work;
  bool ok = false;
  if (ex.dialect.first_g10_work == 1 && p == 0) {
    ok =
        write_axis_words(ex, "work/EXT/", [&](std::size_t i) -> double& { return ex.data.work_external[i]; });
  } else if (system >= 0 && system < 6) {
    auto& zero = ex.data.work[static_cast<std::size_t>(system)];
    ok = write_axis_words(ex, "work/G" + std::to_string(54 + system) + "/",
                          [&](std::size_t i) -> double& { return zero[i]; });
  } else {
    return ex.alarm(AlarmReason::data_number, ex.block['P'].column, "P" + std::to_string(p));
  }
  if (!ok) return false;
  ex.update_zeros();
  return true;
}

bool work_extra_offset(Executor& ex, std::int64_t p) {
  if (p < 1 || p > 48)
    return ex.alarm(AlarmReason::data_number, ex.block['P'].column, "P" + std::to_string(p));
  auto& zero = ex.data.work_extra[static_cast<std::size_t>(p - 1)];
  if (!write_axis_words(ex, "work/G54.1P" + std::to_string(p) + "/",
                        [&](std::size_t i) -> double& { return zero[i]; }))
    return false;
  ex.update_zeros();
  return true;
}

// Mill: L10/L11 length geometry and wear, L12/L13 radius geometry and wear, value in R. Memory A has L1 only.
bool mill_tool(Executor& ex, std::int64_t l, std::int64_t p) {
  ToolOffset* tool = tool_offset(ex, p);
  if (tool == nullptr) return false;
  const auto z = ex.axis_named('Z');
  if (!ex.block.has('R') || !z) return ex.alarm(AlarmReason::data_input, ex.code_column, "R");
  const std::string place = "tool/" + std::to_string(p) + "/";
  double* cell = &tool->geometry[*z];
  std::string what = place + "geometry/Z";
  const bool one_value = tool_offset::one_value(ex);
  if (one_value && l != 1) return ex.alarm(AlarmReason::data_input, ex.code_column, "L" + std::to_string(l));
  if (one_value) {
    // One value a number.
  } else if (l == 11 || l == 1) {
    cell = &tool->wear[*z];
    what = place + "wear/Z";
  } else if (l == 12) {
    cell = &tool->radius;
    what = place + "radius";
  } else if (l == 13) {
    cell = &tool->radius_wear;
    what = place + "radius_wear";
  }
  const double value = ex.length_mm(ex.block['R']) + (ex.incremental ? *cell : 0);
  if (std::fabs(value) > ex.dialect.modes.largest_offset)
    return ex.alarm(AlarmReason::data_value, ex.block['R'].column, "R");
  write(ex, *cell, value, what);
  return true;
}

// Lathe: G10 P n is wear offset n, P 10000+n geometry offset n (0i-D T, K2000TC with wear offsets).
bool lathe_tool(Executor& ex, std::int64_t p) {
  if (p == 0) {
    if (!write_axis_words(ex, "work/shift/", [&](std::size_t i) -> double& { return ex.data.work_shift[i]; }))
      return false;
    ex.update_zeros();
    return true;
  }
  const bool geometry = p >= 10'000;
  const std::int64_t number = geometry ? p - 10'000 : p;
  ToolOffset* tool = tool_offset(ex, number);
  if (tool == nullptr) return false;
  const std::string place = "tool/" + std::to_string(number) + (geometry ? "/geometry/" : "/wear/");
  if (!write_axis_words(
          ex, place, [&](std::size_t i) -> double& { return geometry ? tool->geometry[i] : tool->wear[i]; },
          program::letters("XYZUVW")))
    return false;
  const std::string radius = "tool/" + std::to_string(number) + (geometry ? "/radius" : "/radius_wear");
  double& nose = geometry ? tool->radius : tool->radius_wear;
  for (const char letter : {'R', 'C'}) {  // R sets the nose radius, C adds to it
    if (!ex.block.has(letter)) continue;
    const double value = ex.length_mm(ex.block[letter]) + (letter == 'C' ? nose : 0);
    if (std::fabs(value) > ex.dialect.modes.largest_offset)
      return ex.alarm(AlarmReason::data_value, ex.block[letter].column, std::string(1, letter));
    write(ex, nose, value, radius);
  }
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

// G10 L_ …: what the L says, on which kind of control.
bool data_input(Executor& ex) {
  enum class Series : std::uint8_t { both, lathe, mill };
  struct Form {
    std::int64_t l;
    Series series;
    bool needs_p;
    bool (*input)(Executor&, std::int64_t l, std::int64_t p);
  };
  static constexpr Form kForms[] = {
      {2, Series::both, true, [](Executor& e, std::int64_t, std::int64_t p) { return work_offset(e, p); }},
      {1, Series::lathe, true, [](Executor& e, std::int64_t, std::int64_t p) { return work_offset(e, p); }},
      {10, Series::lathe, true, [](Executor& e, std::int64_t, std::int64_t p) { return lathe_tool(e, p); }},
      {1, Series::mill, true, mill_tool},
      {10, Series::mill, true, mill_tool},
      {11, Series::mill, true, mill_tool},
      {12, Series::mill, true, mill_tool},
      {13, Series::mill, true, mill_tool},
      {20, Series::both, true,
       [](Executor& e, std::int64_t, std::int64_t p) { return work_extra_offset(e, p); }},
      {3, Series::both, false, [](Executor& e, std::int64_t, std::int64_t) { return tool_life::input(e); }},
      {50, Series::both, false, [](Executor& e, std::int64_t, std::int64_t) { return pitch_input(e); }},
      {52, Series::both, false, [](Executor& e, std::int64_t, std::int64_t) { return parameter_input(e); }},
  };
  const program::Block& b = ex.block;
  const bool lathe = ex.dialect.tools.lathe;
  std::int64_t l = lathe ? 10 : tool_offset::one_value(ex) ? 1 : -1;  // memory A: as it is punched (L35127)
  if (b.has('L')) {
    l = ex.whole('L', AlarmReason::data_input);
    if (l < 0) return false;
  }
  const std::uint32_t column = b.has('L') ? b['L'].column : ex.code_column;
  for (const Form& form : kForms) {
    if (form.l != l || (form.series == Series::lathe && !lathe) || (form.series == Series::mill && lathe))
      continue;
    if (l == 20 && ex.table->find(541) == nullptr) break;
    if (l >= 50 && !ex.dialect.modes.parameter_input) break;
    if (!form.needs_p) return form.input(ex, l, 0);
    if (!b.has('P')) return ex.alarm(AlarmReason::data_input, ex.code_column, "P");
    const std::int64_t p = ex.whole('P', AlarmReason::data_number);
    return p >= 0 && form.input(ex, l, p);
  }
  if (!b.has('L')) return ex.alarm(AlarmReason::data_input, ex.code_column, "L");
  return ex.alarm(AlarmReason::g_unavailable, column, "G10 L" + std::to_string(l));
}

// G11: ends a mode of G10; alone it does nothing.
bool data_input_end(Executor& ex) {
  const auto finish = ex.data_input.finish;
  ex.data_input = {};
  return finish == nullptr || finish(ex);
}

}  // namespace headstock::interp::handlers

namespace headstock::interp {

bool Executor::inputs_data() const {
  constexpr std::int16_t kDataInput = 100;
  const auto* const end = block.g.data() + block.g_count;
  return data_input.line != nullptr || std::find_if(block.g.data(), end, [](const program::Code& g) {
                                         return g.tenths == kDataInput;
                                       }) != end;
}

// A RESET in front of it must not leave what a block wrote that did not run: run again, G91 and U W would add
// twice.
bool Executor::data_input_waits() const {
  return !at_standstill && cycle.watch == nullptr && environment->takes_time() && inputs_data();
}

// Every G10 waits for a standstill first, so never more is remembered than the motions still held stand in
// front of.
void Executor::keep_data_input(std::uint32_t first_block_left) {
  std::erase_if(data_input_ahead,
                [first_block_left](const DataInputAhead& one) { return one.block < first_block_left; });
}

// Under G41/G42 one or two motions in front of a G10 wait for the blocks behind it: it is carried out before
// them, and taken back when RESET comes before they are done.
void Executor::take_back_data_input(std::uint32_t first_block_left) {
  std::vector<char> names;
  for (const ProgramAxis& axis : axes) names.push_back(axis.name);
  const auto written = std::exchange(data_input_ahead, {});
  for (auto one = written.rbegin(); one != written.rend(); ++one) {
    if (one->block < first_block_left) continue;
    // What somebody wrote since then stays.
    if (read_value(data, names, one->what).value != one->after) continue;
    if (write_value(data, names, one->what, one->before, dialect.tools.most_offsets))
      report_change(one->what, one->after, one->before);
  }
  update_zeros();
}

}  // namespace headstock::interp
