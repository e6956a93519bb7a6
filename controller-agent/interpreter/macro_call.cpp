// Calls: G65, G66/G67, codes that call by parameter, M198.
#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "interpreter/executor.hpp"

namespace headstock::interp {

namespace {

constexpr std::int32_t kCallTenths = 650, kModalTenths = 660, kCancelTenths = 670;

// Argument type I (0i-D 14.5.1): the variable of a letter; 0: no argument.
constexpr std::array<std::uint8_t, 26> kVariableOf = [] {
  std::array<std::uint8_t, 26> variables{};
  constexpr char kLetters[] = "ABCIJKDEFHMQRSTUVWXYZ";
  constexpr std::uint8_t kNumbers[] = {1,  2,  3,  4,  5,  6,  7,  8,  9,  11, 13,
                                       17, 18, 19, 20, 21, 22, 23, 24, 25, 26};
  for (std::size_t i = 0; i < sizeof kNumbers; ++i)
    variables[program::letter_index(kLetters[i])] = kNumbers[i];
  return variables;
}();

struct Argument {
  std::uint32_t column = 0;
  char letter = 'A';
  double value = macro::kNull;
  std::uint8_t implied_decimals = 0;
};

const CodeCall* find_call(const std::vector<CodeCall>& calls, std::int32_t tenths) {
  for (const CodeCall& call : calls) {
    if (call.tenths == tenths) return &call;
  }
  return nullptr;
}

}  // namespace

// The parameters that make codes call programs, read when a program starts.
void Executor::read_macro_parameters() {
  const macro::Rules& rules = macros->rules;
  const auto whole_parameter = [this](std::string_view number) {
    const double value = number.empty() ? 0 : data.parameter(number);
    return std::fabs(value) < 1e9 ? static_cast<std::int64_t>(value) : 0;
  };
  const auto nth = [&](std::string_view first, int n) {
    int number = 0;
    for (const char digit : first) number = number * 10 + (digit - '0');
    return whole_parameter(std::to_string(number + n));
  };
  macros->g_calls.clear();
  macros->m_calls.clear();
  const auto add = [](std::vector<CodeCall>& calls, std::int64_t first, std::uint32_t program,
                      bool is_macro) {
    const std::int64_t number = std::llabs(first);
    if (first == 0 || number > 99'999'999) return;
    calls.push_back({static_cast<std::int32_t>(number * 10), program, first < 0, is_macro});
  };
  const auto add_row = [&](std::vector<CodeCall>& calls, const macro::CodeCalls& row, bool is_macro) {
    for (int n = 0; n < row.count; ++n)
      add(calls, nth(row.first_parameter, n), row.first_program + static_cast<std::uint32_t>(n), is_macro);
  };
  const auto add_block = [&](std::vector<CodeCall>& calls, const macro::CodeBlockCalls& row, bool is_macro) {
    const std::int64_t first = whole_parameter(row.code), program = whole_parameter(row.program);
    const std::int64_t count = whole_parameter(row.count);
    if (count <= 0 || count > 1'000 || program < 1 || program + count - 1 > 9'999) return;
    for (std::int64_t n = 0; n < count; ++n)
      add(calls, first < 0 ? first - n : first + n, static_cast<std::uint32_t>(program + n), is_macro);
  };
  // A macro wins over a sub-program, the lower parameter over the higher, single codes over blocks of them.
  add_row(macros->g_calls, rules.g_macros, true);
  add_block(macros->g_calls, rules.g_macro_block, true);
  add_row(macros->m_calls, rules.m_macros, true);
  add_block(macros->m_calls, rules.m_macro_block, true);
  add_row(macros->m_calls, rules.m_subs, false);
  add_block(macros->m_calls, rules.m_sub_block, false);
  std::erase_if(macros->g_calls, [](const CodeCall& call) {
    return call.tenths == 50 || call.tenths == kCallTenths || call.tenths == kModalTenths ||
           call.tenths == kCancelTenths;
  });
  std::erase_if(macros->m_calls, [](const CodeCall& call) {
    return call.tenths < 30 || call.tenths == 300 || call.tenths == 980 || call.tenths == 990;
  });
  macros->t_calls = data.bit(rules.t_sub_parameter);
  for (std::size_t i = 0; i < macros->call_letters.size(); ++i) {
    const std::int64_t letter = whole_parameter(rules.address_parameters[i]);
    macros->call_letters[i] = letter >= 'A' && letter <= 'Z' ? static_cast<char>(letter) : '\0';
  }
  const std::int64_t external = whole_parameter(rules.external_m_parameter);
  const bool is_set = external > 2 && external != 30 && external != 98 && external != 99;
  macros->external_m = rules.external_call ? is_set ? static_cast<std::int32_t>(external) : 198 : -1;
  interruption.on_code = rules.interruption ? 96 : -1;
  interruption.off_code = rules.interruption ? 97 : -1;
  if (rules.interruption && data.bit(rules.interruption_codes_parameter)) {
    interruption.on_code = static_cast<std::int32_t>(whole_parameter(rules.interruption_on_parameter));
    interruption.off_code = static_cast<std::int32_t>(whole_parameter(rules.interruption_off_parameter));
  }
  macros->calls_by_code = !macros->g_calls.empty() || !macros->m_calls.empty() || macros->t_calls ||
                          macros->call_letters[0] != '\0' || macros->call_letters[1] != '\0';
  macro::Variables& variables = macros->variables;
  variables.signed_angles = data.bit(rules.signed_angles_parameter);
  variables.eight_digits = data.bit(rules.eight_digits_parameter);
  variables.adp_refused = data.bit(rules.converted_arguments_parameter);
  variables.protect_first = static_cast<std::uint32_t>(whole_parameter(rules.protect_first));
  variables.protect_last = static_cast<std::uint32_t>(whole_parameter(rules.protect_last));
}

// Levels of macro calls, of sub-program calls, and of both (0i-D L17895).
bool Executor::nesting_allows(CallKind kind, std::uint32_t column) {
  int subs = 0, macro_calls = 0;
  for (const Frame& frame : frames) {
    subs += frame.macro.kind == CallKind::sub ? 1 : 0;
    macro_calls += frame.macro.kind == CallKind::macro || frame.macro.kind == CallKind::modal ? 1 : 0;
  }
  if (kind == CallKind::sub) {
    if (subs >= dialect.calls.nesting) return alarm(AlarmReason::nesting, column);
  } else if (macro_calls >= macros->rules.macro_nesting) {
    return alarm(AlarmReason::macro_nesting, column);
  }
  if (macros != nullptr && subs + macro_calls >= macros->rules.all_nesting)
    return alarm(kind == CallKind::sub ? AlarmReason::nesting : AlarmReason::macro_nesting, column);
  return true;
}

// Decimals that an argument without a point is taken to have (0i-D L18211-18399).
int Executor::argument_decimals(char letter) const {
  const std::uint32_t bit = letter_bit(letter);
  const auto decimals_of = [](std::int64_t increment) {
    int decimals = 0;
    for (std::int64_t unit = increment; unit < program::kNano; unit *= 10) ++decimals;
    return decimals;
  };
  if (pocket && !data.bit(macros->rules.typed_arguments_parameter)) return 0;
  const auto axis = axis_of[program::letter_index(letter)];
  if (axis >= 0) return decimals_of(axes[static_cast<std::size_t>(axis)].increment);
  if (letter == 'F' || (letter == 'E' && dialect.tools.lathe)) {
    const auto& numbers = dialect.numbers;
    double unit = 0.001;
    if (feed_unit == FeedUnit::mm_per_minute)
      unit = modal.inch ? numbers.feed_per_minute_unit_inch : numbers.feed_per_minute_unit_mm;
    if (feed_unit == FeedUnit::mm_per_revolution)
      unit = modal.inch ? numbers.feed_per_revolution_unit_inch : numbers.feed_per_revolution_unit_mm;
    return static_cast<int>(std::lround(-std::log10(unit)));
  }
  if (letter == 'D' && data.bit(macros->rules.decimal_d_parameter)) return decimals_of(linear_increment);
  return (macros->rules.whole_arguments & bit) != 0 ? 0 : decimals_of(linear_increment);
}

bool Executor::gather_arguments(std::uint32_t column, std::int32_t call_m, macro::LocalSet& locals) {
  std::array<Argument, 26 + program::kMostEarlier + program::kMostCodes> arguments;
  std::size_t count = 0;
  const auto take = [&](const program::Word& word, char letter, std::uint8_t place) {
    Argument& argument = arguments[count++];
    argument.column = word.column;
    argument.letter = letter;
    argument.value = word.value();
    if (!word.point) {
      argument.implied_decimals = static_cast<std::uint8_t>(argument_decimals(letter));
      argument.value /= static_cast<double>(program::kPowerOfTen[argument.implied_decimals]);
    }
    for (std::size_t i = 0; i < block.computed_count; ++i) {  // as computed, not rounded to the address
      if (block.computed[i].letter == letter && block.computed[i].place == place && !block.computed[i].marked)
        argument.value = macros->computed[i];
    }
  };
  for (std::uint32_t mask = block.words; mask != 0; mask &= mask - 1) {
    const auto letter = static_cast<std::size_t>(std::countr_zero(mask));
    const char name = static_cast<char>('A' + letter);
    if (name != 'P' && name != 'L') take(block.word[letter], name, 0);
  }
  for (std::size_t i = 0; i < block.earlier_count; ++i) {
    const program::EarlierWord& word = block.earlier[i];
    if (word.letter != 'P' && word.letter != 'L')
      take(word.word, word.letter, static_cast<std::uint8_t>(i + 1));
  }
  for (std::size_t i = 0; i < block.m_count; ++i) {
    if (block.m[i].tenths == call_m) continue;
    if (block.m[i].tenths < 0) return alarm(AlarmReason::too_many_digits, block.m[i].column, "M");
    arguments[count++] = {block.m[i].column, 'M', block.m[i].tenths / 10.0, 0};
  }
  std::sort(arguments.begin(), arguments.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Argument& a, const Argument& b) { return a.column < b.column; });

  const bool groups = macros->rules.type_two && !data.bit(macros->rules.type_one_parameter);
  unsigned group = 0;
  int last = -1;
  for (std::size_t i = 0; i < count; ++i) {
    const Argument& argument = arguments[i];
    const std::string name(1, argument.letter);
    if (argument.column < column) return alarm(AlarmReason::macro_with_words, argument.column, name);
    std::size_t variable = kVariableOf[program::letter_index(argument.letter)];
    const int place = argument.letter - 'I';
    if (groups && place >= 0 && place <= 2) {  // to the next free place of I J K (L18066)
      if (place <= last) ++group;
      last = place;
      if (group > 9) return alarm(AlarmReason::macro_groups, argument.column, name);
      variable = 4 + 3 * group + static_cast<unsigned>(place);
    }
    if (variable == 0) return alarm(AlarmReason::illegal_address, argument.column, name);
    locals.values[variable] = argument.value;
    locals.implied_decimals[variable] = argument.implied_decimals;
  }
  return true;
}

bool Executor::call_macro(std::uint32_t number, std::uint32_t column, bool modal_call) {
  std::int64_t times = 1;
  if (block.has('L')) {
    times = whole('L', AlarmReason::call_count);
    if (times < 0) return false;
    if (times > macros->rules.most_repeats) return alarm(AlarmReason::call_count, block['L'].column, "L");
  }
  std::int32_t call_m = -1;
  for (std::size_t i = 0; i < block.m_count; ++i) {
    if (block.m[i].column == column) call_m = block.m[i].tenths;
  }
  auto locals = std::make_shared<macro::LocalSet>();
  if (!gather_arguments(column, call_m, *locals)) return false;
  const bool by_code = block.g_count == 0 || call_m >= 0 ||
                       (block.g[0].tenths != kCallTenths && block.g[0].tenths != kModalTenths);
  if (modal_call) {
    auto call = std::make_shared<ModalCall>();
    call->program = number;
    call->times = times;
    call->locals = std::move(locals);
    frames.back().macro.modal_calls.push_back(std::move(call));
    if (const GCode* row = table->find(kModalTenths); row != nullptr) modal.g[row->group] = kModalTenths;
    return true;
  }
  if (!nesting_allows(CallKind::macro, column) || !count_jump()) return false;
  auto& compiled = macros->programs[number];
  std::unique_ptr<program::Source> source;
  if (compiled == nullptr || compiled->find(0) == nullptr) {
    source = programs == nullptr ? nullptr : programs->open_number(number);
    if (source == nullptr) return alarm(AlarmReason::program_not_found, column, "O" + std::to_string(number));
    if (compiled == nullptr) compiled = std::make_shared<CompiledProgram>();
  }
  if (times == 0) return true;
  Frame& frame = push_program(std::move(source), number, times);
  frame.macro.kind = CallKind::macro;
  frame.macro.code = compiled;
  frame.macro.by_code = frame.macro.by_code || by_code;
  if (times > 1) frame.macro.arguments = std::make_unique<macro::LocalSet>(*locals);
  frame.macro.locals = std::move(locals);
  macros->variables.locals = frame.macro.locals.get();
  frame.macro.next = compiled->find(0);
  frame.macro.displaced = frame.macro.next != nullptr;
  return true;
}

// After a move under G66. Moves of the macro itself call the modal macro that was given before (0i-D L18822).
bool Executor::call_modal() {
  const ModalCalls calls = frames.back().macro.modal_calls;
  const ModalCall& modal_call = *calls.back();
  if (modal_call.times == 0) return true;
  if (!nesting_allows(CallKind::modal, 0) || !count_jump()) return false;
  auto& compiled = macros->programs[modal_call.program];
  std::unique_ptr<program::Source> source;
  if (compiled == nullptr || compiled->find(0) == nullptr) {
    source = programs == nullptr ? nullptr : programs->open_number(modal_call.program);
    if (source == nullptr)
      return alarm(AlarmReason::program_not_found, 0, "O" + std::to_string(modal_call.program));
    if (compiled == nullptr) compiled = std::make_shared<CompiledProgram>();
  }
  Frame& frame = push_program(std::move(source), modal_call.program, modal_call.times);
  frame.macro.kind = CallKind::modal;
  frame.macro.code = compiled;
  frame.macro.locals = modal_call.locals;
  frame.macro.modal_calls.assign(calls.begin(), calls.end() - 1);
  macros->variables.locals = frame.macro.locals.get();
  frame.macro.next = compiled->find(0);
  frame.macro.displaced = frame.macro.next != nullptr;
  return true;
}

bool Executor::cancel_modal(std::uint32_t column) {
  ModalCalls& calls = frames.back().macro.modal_calls;
  if (calls.empty()) {
    return data.bit(macros->rules.lone_cancel_parameter) || alarm(AlarmReason::macro_cancel, column, "G67");
  }
  calls.pop_back();
  if (const GCode* row = table->find(kCancelTenths); row != nullptr && calls.empty())
    modal.g[row->group] = kCancelTenths;
  return true;
}

bool Executor::take_calls(bool& taken) {
  taken = false;
  const macro::Rules& rules = macros->rules;
  const bool codes_call =
      macros->calls_by_code && (!frames.back().macro.by_code || data.bit(rules.nested_codes_parameter));
  for (std::size_t i = 0; i < block.g_count; ++i) {
    const program::Code written = block.g[i];
    const CodeCall* by_code = codes_call ? find_call(macros->g_calls, written.tenths) : nullptr;
    const bool plain = written.tenths == kCallTenths && rules.macro_calls;
    const bool modal_code =
        (written.tenths == kModalTenths || written.tenths == kCancelTenths) && rules.modal_calls;
    if (by_code == nullptr && !plain && !modal_code) continue;
    if (plain && block.has('H') && (rules.h_codes || block['H'].column < block['P'].column)) return true;
    if (block.g_count > 1) {
      const program::Code& other = block.g[i == 0 ? 1 : 0];
      const bool call_too = other.tenths == kCallTenths || other.tenths == kModalTenths;
      return alarm(call_too                        ? AlarmReason::macro_call_twice
                   : other.column < written.column ? AlarmReason::macro_with_words
                                                   : AlarmReason::macro_g_argument,
                   other, 'G');
    }
    taken = true;
    if (written.tenths == kCancelTenths && by_code == nullptr) {
      if ((block.words | block.m_count) != 0) return alarm(AlarmReason::macro_with_words, written, 'G');
      return cancel_modal(written.column);
    }
    if (by_code != nullptr) {
      return call_macro(by_code->program, written.column, by_code->modal);
    }
    if (!block.has('P')) return alarm(AlarmReason::call_without_p, written, 'G');
    const std::int64_t number = whole('P', AlarmReason::call_without_p);
    if (number < 0) return false;
    if (block['P'].column < written.column || (block.has('L') && block['L'].column < written.column))
      return alarm(AlarmReason::macro_with_words, block['P'].column, "P");
    return call_macro(static_cast<std::uint32_t>(number), written.column, written.tenths == kModalTenths);
  }
  for (std::size_t i = 0; i < block.m_count; ++i) {
    const program::Code written = block.m[i];
    if (written.tenths == macros->external_m * 10) {
      program::remove_code(block.m, block.m_count, i--);
      if (!call_external(written.column)) return false;
      continue;
    }
    if (interruption.on_code > 0 &&
        (written.tenths == interruption.on_code * 10 || written.tenths == interruption.off_code * 10)) {
      program::remove_code(block.m, block.m_count, i--);
      if (!allow_interruption(written, written.tenths == interruption.on_code * 10)) return false;
      continue;
    }
    const CodeCall* by_code = codes_call ? find_call(macros->m_calls, written.tenths) : nullptr;
    if (by_code == nullptr) continue;
    if (by_code->macro) {
      taken = true;
      if (block.g_count != 0) {
        return alarm(block.g[0].column < written.column ? AlarmReason::macro_with_words
                                                        : AlarmReason::macro_g_argument,
                     block.g[0], 'G');
      }
      return call_macro(by_code->program, written.column, false);
    }
    if (sub_call != nullptr) return alarm(AlarmReason::sub_call_twice, written, 'M');
    program::remove_code(block.m, block.m_count, i--);
    sub_call = by_code;
    sub_call_column = written.column;
  }
  if (!codes_call) return true;
  const auto call_by_word = [&](char letter, std::uint32_t program, std::uint16_t variable, double value) {
    const std::uint32_t column = block[letter].column;
    if (sub_call != nullptr) return alarm(AlarmReason::sub_call_twice, column, std::string(1, letter));
    block.words &= ~letter_bit(letter);
    block.pointed &= ~letter_bit(letter);
    block.negative &= ~letter_bit(letter);
    (void)macros->variables.write(variable, value);
    word_call = {0, program, false, false};
    sub_call = &word_call;
    sub_call_column = column;
    return true;
  };
  if (macros->t_calls && block.has('T')) {
    const std::int64_t value = whole('T', AlarmReason::value_range);
    if (value < 0 ||
        !call_by_word('T', rules.t_sub_program, rules.t_sub_variable, static_cast<double>(value)))
      return false;
  }
  for (std::size_t i = 0; i < macros->call_letters.size(); ++i) {
    const char letter = macros->call_letters[i];
    if (letter == '\0' || !block.has(letter)) continue;
    const program::Word& word = block[letter];
    int decimals = argument_decimals(letter);
    // The second auxiliary function's address in its own units (0i-D No.3450#0 and #7, L58763).
    const bool has_its_unit =
        letter == auxiliary_letter ||
        (data.bit(dialect.modes.auxiliary_unit_parameter) && letter == auxiliary_address());
    if (!pocket && has_its_unit && data.bit(dialect.modes.auxiliary_decimal_parameter))
      for (std::int64_t unit = linear_increment; unit < program::kNano; unit *= 10) ++decimals;
    const double value =
        word.point ? word.value()
                   : word.value() / static_cast<double>(program::kPowerOfTen[static_cast<std::size_t>(decimals)]);
    if (!call_by_word(letter, rules.address_programs[i], rules.address_variables[i], value)) return false;
  }
  return true;
}

bool Executor::call_external(std::uint32_t column) {
  if (frames.back().macro.external) return alarm(AlarmReason::external_twice, column, "M198");
  if (switches.origin == ProgramOrigin::mdi && !data.bit(macros->rules.external_in_mdi_parameter))
    return alarm(AlarmReason::external_in_mdi, column, "M198");
  if (switches.origin == ProgramOrigin::dnc) return alarm(AlarmReason::external_in_dnc, column, "M198");
  if (sub_call != nullptr) return alarm(AlarmReason::sub_call_twice, column, "M198");
  if (!block.has('P')) return alarm(AlarmReason::call_without_p, column, "M198");
  const std::int64_t number = whole('P', AlarmReason::call_without_p);
  if (number < 0) return false;
  word_call = {-1, static_cast<std::uint32_t>(number), false, false};
  sub_call = &word_call;
  sub_call_column = column;
  return true;
}

// The sub-program that a code of this block calls, after the block has been done.
bool Executor::run_pending_call() {
  const CodeCall wanted = *std::exchange(sub_call, nullptr);
  const bool external = wanted.tenths == -1;
  std::int64_t times = 1;
  if (block.has('L')) {
    times = whole('L', AlarmReason::call_count);
    if (times < 0) return false;
    if (times > macros->rules.most_code_repeats)
      return alarm(AlarmReason::call_count, block['L'].column, "L");
  }
  if (times == 0) return true;
  if (!nesting_allows(CallKind::sub, sub_call_column) || !count_jump()) return false;
  std::unique_ptr<program::Source> source;
  if (programs != nullptr)
    source = external ? programs->open_external(wanted.program) : programs->open_number(wanted.program);
  if (source == nullptr) {
    return alarm(external ? AlarmReason::external_not_found : AlarmReason::program_not_found, sub_call_column,
                 "O" + std::to_string(wanted.program));
  }
  Frame& frame = push_program(std::move(source), wanted.program, times);
  frame.macro.external = external || frame.macro.external;
  frame.macro.by_code = frame.macro.by_code || !external;
  if (!external) {
    auto& compiled = macros->programs[wanted.program];
    if (compiled == nullptr) compiled = std::make_shared<CompiledProgram>();
    frame.macro.code = compiled;
  }
  return true;
}

}  // namespace headstock::interp
