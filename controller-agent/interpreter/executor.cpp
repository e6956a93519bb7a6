#include "interpreter/executor.hpp"

#include <algorithm>
#include <utility>

#include "interpreter/data_values.hpp"

namespace headstock::interp {
namespace {

using program::letters;

// Letters that name axes, and on a lathe the letters of their increments.
constexpr std::string_view kAxisNames = "XYZABCUVW";
constexpr std::uint32_t kStepsBetweenQuestions = 1'024;
constexpr std::string_view kIncrementOf = "XUYVZWCH";  // pairs: axis, its increment

}  // namespace

Executor::Executor(const Dialect& d, const machine::Machine& m, MachineData& machine_data,
                   program::Programs* callable)
    : dialect(d), machine(m), data(machine_data), programs(callable) {
  axes.resize(std::min(machine.axes.size(), kMaxAxes));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    axes[i].name = machine.axes[i].name;
    axes[i].rotary = machine.axes[i].rotary;
    axes[i].diameter = machine.axes[i].designation == machine::Designation::diameter ? 0.5 : 1;
  }
  select_plane(dialect.tools.lathe ? Plane::zx : Plane::xy);
  queue.reserve(8);
  if (dialect.macros != nullptr) {
    macros = std::make_unique<MacroState>(*this, *dialect.macros, dialect.tools.lathe);
    lex_rules.expressions = &macros->words;
    load_variables();
    macros->variables.power_on();
    flush_changes();
  }
  if (dialect.make_own != nullptr) own = dialect.make_own(*this);
  modal.g.fill(-1);
  set_units(false);
  set_switches({});
  update_zeros();
}

void Executor::set_switches(const Switches& wanted) {
  char wanted_system = wanted.gcode_system;  // A is also "as the parameters say"
  if (wanted_system == 'A' && data.bit(dialect.modes.system_b_parameter)) wanted_system = 'B';
  if (wanted_system == 'A' && data.bit(dialect.modes.system_c_parameter)) wanted_system = 'C';
  const bool other_system = table == nullptr || wanted_system != gcode_system;
  gcode_system = wanted_system;
  switches = wanted;
  const std::size_t system = gcode_system == 'C' ? 2 : gcode_system == 'B' ? 1 : 0;
  const auto& numbers = dialect.numbers;
  if (other_system) table = &dialect.table(gcode_system);

  using dialects::Decimal;
  Decimal decimal = data.bit(numbers.decimal_parameter) ? numbers.decimal_when_set : numbers.decimal;
  if (data.parameter(numbers.standard_when_clear_parameter, 1) == 0) decimal = Decimal::standard;
  if (switches.decimal_point == DecimalPoint::standard) decimal = Decimal::standard;
  if (switches.decimal_point == DecimalPoint::pocket || switches.lenient) decimal = Decimal::pocket;
  pocket = decimal == Decimal::pocket;

  lex_rules.semicolon_is_comment = switches.lenient;
  lex_rules.comma_letters =
      dialect.corners.comma_parameter.empty() || data.parameter(dialect.corners.comma_parameter, 1) != 0
          ? dialect.corners.comma_letters
          : 0;
  lex_rules.named_letters = dialect.corners.named_letters;
  lex_rules.most_digits = switches.lenient ? 17 : numbers.most_digits;

  axis_of.fill(-1);
  absolute_letters = incremental_letters = 0;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const char name = axes[i].name;
    if (kAxisNames.find(name) == kAxisNames.npos) continue;
    axis_of[program::letter_index(name)] = static_cast<std::int8_t>(i);
    absolute_letters |= letter_bit(name);
  }
  if (dialect.incremental_letters[system]) {
    for (std::size_t pair = 0; pair < kIncrementOf.size(); pair += 2) {
      const auto axis = axis_of[program::letter_index(kIncrementOf[pair])];
      const char letter = kIncrementOf[pair + 1];
      if (axis < 0 || (absolute_letters & letter_bit(letter)) != 0) continue;
      axis_of[program::letter_index(letter)] = axis;
      incremental_letters |= letter_bit(letter);
    }
  }
  axis_letters = absolute_letters | incremental_letters;
  axis_like = letters("XYZABCUVW") | (dialect.tools.lathe ? letter_bit('H') : 0);
  constexpr std::uint32_t kAll = (1u << 26) - 1;
  legal = switches.lenient ? kAll : numbers.addresses;
  may_point = switches.lenient ? kAll : numbers.pointed;
  if (data.bit(numbers.pointed_counts_parameter)) may_point |= letters("PQ");
  may_minus = switches.lenient ? kAll : numbers.negative | axis_letters;
  if (other_system) power_on();
}

// Every group's marked code, then what the parameters choose instead.
void Executor::power_on(std::uint32_t keep) {
  block.clear();
  const auto put_in_force = [this, keep](const GCode& row) {
    if ((keep >> row.group & 1u) != 0) return;
    if (row.group != 0) modal.g[row.group] = row.tenths;
    if (row.phase == Phase::motion) motion_code = &row;  // G80 is in force as a setting
    if (row.phase == Phase::setting && row.handler != nullptr) {
      code = &row;
      row.handler(*this);
    }
  };
  const bool inch = modal.inch;  // the unit survives reset and power-off (0i-D 3)
  for (std::size_t group = 0; group < modal.g.size(); ++group) {
    if ((keep >> group & 1u) == 0) modal.g[group] = -1;
  }
  for (const GCode& row : table->rows()) {
    if (row.power_on) put_in_force(row);
  }
  const std::size_t system = gcode_system == 'C' ? 2 : gcode_system == 'B' ? 1 : 0;
  for (const auto& chosen : dialect.power_on_switches) {
    const GCode* row = data.bit(chosen.parameter) ? table->find(chosen.tenths[system]) : nullptr;
    if (row != nullptr) put_in_force(*row);
  }
  set_units(inch);
  feed_mm = dialect.numbers.power_on_feed_mm_min;
  if (own) own->power_on(*this);
}

void Executor::start(std::unique_ptr<program::Source> main, const AxisVector& machine_position) {
  leave_surface();
  surface = {};
  surface_path = {};
  leave_program();
  interruption.enabled = false;
  push_program(std::move(main), 0, 1);
  if (macros != nullptr) {
    load_variables();
    macros->programs.clear();
    read_macro_parameters();
    frames.back().macro.locals = std::make_shared<macro::LocalSet>(
        macros->keeps_locals(data) ? macros->kept_locals : macro::LocalSet());
    macros->variables.locals = frames.back().macro.locals.get();
    macros->history = {};
  }
  sub_call = nullptr;
  barrier = awaits_standstill = false;
  at_standstill = true;
  queue.clear();
  queue_head = 0;
  cancel_compensation();
  cycle.clear();
  finished = false;
  jumps = idle_jumps = 0;
  if (restarting) leave_search();
  modal_memory.forget();
  at = {};
  tool_life::begin_run(*this);
  data_input = {};
  data_input_ahead.clear();
  take_parameters();
  if (own) own->start(*this);
  update_zeros();
  set_position(machine_position);
  take_mirror_setting();
}

Pull Executor::next(Operation& wanted) {
  if (restarting) {
    if (const Pull reached = run_through(); reached != Pull::operation && reached != Pull::finished) return reached;
  }
  out = &wanted;
  out_used = false;
  if (macros != nullptr && macros->common_version != data.version) load_variables();
  if (awaits_standstill) {  // asked again: everything has been carried out
    awaits_standstill = false;
    at_standstill = true;
  }
  for (;;) {
    if (queue_head < queue.size()) {
      wanted = std::move(queue[queue_head++]);
      if (queue_head == queue.size()) {
        queue.clear();
        queue_head = 0;
      }
      return Pull::operation;
    }
    if (finished) return Pull::finished;
    if (cycle.running != nullptr) {
      if (!cycle.running->next(*this)) {
        cycle.running.reset();
        cycle.name = nullptr;
        if (!finished) run_deferred();
      }
      if (pipeline.active()) pipeline.take(*this);
      if (out_used) return Pull::operation;
      continue;
    }
    if (pipeline.active()) pipeline.open_intake(*this);
    const Step result = step();
    if (pipeline.active()) {
      pipeline.take(*this);
    } else {
      pipeline.close_intake(*this);
    }
    if (macros != nullptr && macros->variables.has_changes() &&
        (out_used || finished || result != Step::done))
      flush_changes();
    if (finished) leave_program();  // files are closed, a drip-feed is told
    if (out_used) return Pull::operation;
    if (result == Step::wait) return Pull::wait;
    if (result == Step::standstill) {
      awaits_standstill = true;
      return Pull::standstill;
    }
    if (++steps % kStepsBetweenQuestions != 0) continue;
    if (environment->wants_stop()) {
      finished = true;
      leave_program();
      if (macros != nullptr) flush_changes();
      return Pull::finished;
    }
    if (environment->wants_pause()) {
      if (macros != nullptr) flush_changes();
      return Pull::pause;
    }
  }
}

void Executor::leave_program() {
  if (macros != nullptr) {
    if (!frames.empty() && frames.front().macro.locals != nullptr && macros->keeps_locals(data))
      macros->kept_locals = *frames.front().macro.locals;
    macros->variables.forget_locals();
  }
  frames.clear();
}

// Variables are stored when something comes out: a loop that counts up is one change.
void Executor::flush_changes() {
  for (const auto& [number, before] : macros->variables.take_changes()) {
    const double now = macros->common.get(number);
    if (macro::is_null(now)) {
      data.common_variables.erase(number);
    } else {
      data.common_variables[number] = now;
    }
    report_change("variable/" + std::to_string(number), before, now);
  }
  macros->common_version = data.version;
}

// Somebody else changed the machine's data: the operator, or G10.
void Executor::load_variables() {
  macros->common.load(data.common_variables);
  for (const auto& [number, name] : data.variable_names) macros->variables.name(number, name);
  macros->common_version = data.version;
}

void Executor::reset(const AxisVector& machine_position, std::uint32_t first_block_left) {
  if (restarting) leave_search();
  leave_program();
  queue.clear();
  queue_head = 0;
  // The block that ended in an alarm was not carried out (0i-D K.32.1).
  const std::uint32_t back_to = first_block_left != 0 ? first_block_left : modal_memory.failed_block();
  if (back_to != 0) {
    take_back_data_input(back_to);
    modal_memory.back_to(*this, back_to);
  }
  data_input_ahead.clear();
  cancel_compensation();
  cycle.clear();
  interruption.enabled = false;
  finished = true;
  clear_modes();
  if (macros != nullptr) {
    load_variables();
    reset_variables();
    flush_changes();
  }
  spindle_direction = SpindleDirection::stop;
  tool_life::leave(*this);
  if (own) own->reset(*this);
  set_position(machine_position);
}

// A program begins in G40, and RESET leaves it so (0i-D, K2000TC L16153).
void Executor::cancel_compensation() {
  pipeline.clear();
  if (const GCode* cancel = table->find(400); cancel != nullptr && cancel->group != 0) {
    modal.g[cancel->group] = cancel->tenths;
  }
}

void Executor::reset_variables() {
  const macro::Rules& rules = macros->rules;
  const bool kept = data.bit(rules.keep_volatile_parameter) ||
                    (!rules.clear_volatile_parameter.empty() && !data.bit(rules.clear_volatile_parameter));
  if (!kept) macros->variables.clear_volatile();
  macros->control = modal.macro_control = 0;
}

void Executor::set_position(const AxisVector& machine_position) {
  const AxisVector place = place_in_plane(machine_position);
  for (std::size_t i = 0; i < axes.size(); ++i) set_axis_machine(i, place[i]);
  normal_direction.stand(*this);
}

AxisVector Executor::to_work(const AxisVector& machine_position, const ModalSnapshot& under) const {
  AxisVector work{};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double unit = under.inch && !axes[i].rotary ? 25.4 : 1;
    work[i] = within_turn(i, (machine_position[i] - under.work_zero[i]) / (axes[i].diameter * unit));
  }
  return work;
}

bool Executor::alarm(AlarmReason reason, std::uint32_t column, std::string detail) {
  return alarm_code(dialect.alarm_code(reason), column, std::move(detail));
}

bool Executor::alarm_code(std::string_view number, std::uint32_t column, std::string detail) {
  if (finished) return false;
  auto& raised = emit<Alarm>();
  raised.at = at;
  raised.at.column = column;
  raised.code = number;
  raised.detail = std::move(detail);
  finished = true;
  modal_memory.alarm_raised();
  return false;
}

bool Executor::alarm(AlarmReason reason, const program::Code& wrong, char letter) {
  std::string text(1, letter);
  if (wrong.tenths >= 0) {
    text += std::to_string(wrong.tenths / 10);
    if (wrong.tenths % 10 != 0) text += '.' + std::to_string(wrong.tenths % 10);
  }
  return alarm(reason, wrong.column, std::move(text));
}

namespace {

/// By which code of the block a value was written: histories name it.
std::string_view change_source(const program::Block& block) {
  struct Source {
    std::int16_t tenths;
    std::string_view name;
  };
  static constexpr Source kSources[] = {{100, "G10"},         {310, "measurement"}, {360, "measurement"},
                                        {370, "measurement"}, {371, "measurement"}, {372, "measurement"},
                                        {373, "measurement"}};
  for (std::size_t i = 0; i < block.g_count; ++i)
    for (const Source& source : kSources)
      if (block.g[i].tenths == source.tenths) return source.name;
  return "program";
}

}  // namespace

void Executor::report_change(std::string what, double before, double after) {
  ++data.version;
  // Values that may have been added to; the others are the same when they are written again.
  const ValueKind kind = kind_of_value(what);
  const bool may_be_added_to = kind == ValueKind::tool || kind == ValueKind::work;
  if (may_be_added_to && environment->takes_time() && pipeline.holds_motion() && inputs_data())
    data_input_ahead.push_back({at.block, what, before, after});
  if (changed && !restarting) changed({std::move(what), before, after, change_source(block)});
}

}  // namespace headstock::interp
