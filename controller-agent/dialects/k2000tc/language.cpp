// Calls, user codes, conditional jumps and the life of the language's memory.
#include "dialects/k2000tc/language.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace headstock::dialects::k2000tc {
namespace {

using k2000::Error;
using program::letter_bit;

// Letter → local variable of G65 and of user codes (L20150).
constexpr struct {
  char letter;
  std::uint8_t variable;
} kArguments[] = {{'A', 1},  {'B', 2},  {'C', 3},  {'D', 7},  {'E', 8},  {'F', 9},  {'H', 11},
                  {'I', 4},  {'J', 5},  {'K', 6},  {'M', 13}, {'Q', 17}, {'R', 18}, {'S', 19},
                  {'T', 20}, {'U', 21}, {'V', 22}, {'W', 23}, {'X', 24}, {'Y', 25}, {'Z', 26}};
constexpr std::uint32_t kLengths =
    program::letters("ABCIJKRUVWXYZ");  // count in least increments without a point

// M, S and T codes are passed as they stand in BCD (L20160): 22 is 34.
std::int64_t to_bcd(std::int64_t value) {
  std::int64_t out = 0, scale = 1;
  for (; value > 0; value /= 10, scale *= 16) out += value % 10 * scale;
  return out;
}

double from_bcd(double value) {
  if (!(value >= 0 && value < 4294967296.0)) return -1;
  auto rest = static_cast<std::uint64_t>(value);
  std::uint64_t out = 0, scale = 1;
  for (; rest != 0; rest >>= 4, scale *= 10) {
    if ((rest & 15) > 9) return -1;
    out += (rest & 15) * scale;
  }
  return static_cast<double>(out);
}

}  // namespace

Language& language(Executor& ex) {
  return static_cast<Language&>(*ex.own);
}

Language::Level& Language::level(Executor& ex) {
  while (levels_.size() < ex.frames.size()) {
    levels_.emplace_back();
    levels_.back().own_locals = levels_.size() == 1;
  }
  return levels_[ex.frames.size() - 1];
}

void Language::power_on(Executor& ex) {
  if (!ex.frames.empty()) return;  // an interruption begins with these codes, not with an empty memory
  levels_.clear();
  auto& stored = ex.data.common_variables;
  for (auto it = stored.begin(); it != stored.end();) it = it->first < 500 ? stored.erase(it) : std::next(it);
}

void Language::start(Executor& ex) {
  const auto& data = ex.data;
  const auto bit = [&data](std::string_view number, double otherwise) {
    return data.parameter(number, otherwise) != 0;
  };
  options_.degrees = bit("P4100.6", 1);
  options_.signed_atan = bit("P4100.0", 0);
  options_.zero_is_null = bit("P4100.1", 0);
  other_brackets_ = !bit("P4100.5", 1);
  ex.lex_rules.expressions = &reader_;
  ex.lex_rules.named_letters = program::letters("XYZUVWABCIJKQRFEDHLP");
  ex.lex_rules.comma_letters = bit("P2500.2", 0) ? ex.lex_rules.named_letters : 0;  // CENCW (L9319)
  levels_.clear();
  write_open_ = false;
  leave_modes(ex);
  // P0412 of a rotary axis: 1 A, endless; 2 B, one turn, as written; 3 C, one turn, the shorter way; 4 D, as
  // C from -180 to 180 (L1100).
  ex.any_rolls_over = false;
  for (auto& axis : ex.axes) {
    const int type = axis.rotary ? static_cast<int>(data.parameter(std::string("P0412/") + axis.name, 1)) : 0;
    axis.rolls_over = type >= 2 && type <= 4;
    axis.as_written = type == 2;
    axis.centered = type == 4;
    axis.turn = 360 * program::kNano;
    ex.any_rolls_over = ex.any_rolls_over || axis.rolls_over;
  }

  const auto codes = [&data](int first, int count, int program, std::map<std::int64_t, std::uint32_t>& into) {
    into.clear();
    for (int i = 0; i < count; ++i) {
      const double code = data.parameter("P" + std::to_string(first + i), 0);
      const double target = data.parameter("P" + std::to_string(program - 5'000 + i), program + i);
      if (code > 0) into[static_cast<std::int64_t>(code)] = static_cast<std::uint32_t>(target);
    }
  };
  codes(4'120, 20, 9'320, user_g_);
  codes(4'200, 20, 9'400, user_m_);
  codes(4'250, 10, 9'450, user_t_);
}

// What a reset, and the start of a program, puts back (L3640, L4180, L6120, L7376).
void Language::leave_modes(Executor& ex) {
  curve.reset();
  hypothetical = 0;
  thread.on = false;
  fast_feed = -1;
  for (std::size_t i = 0; i < ex.axes.size(); ++i) {
    auto& axis = ex.axes[i];
    if (axis.page_diameter == 0) continue;
    axis.diameter = axis.page_diameter;
    axis.page_diameter = 0;
    ex.set_units(ex.modal.inch);
  }
  if (ex.roles_given) {
    ex.roles_given = false;
    ex.select_plane(ex.plane);
  }
}

namespace {

// What outlives RESET; the other modes end with it.
struct KeptWords : interp::OwnModes {
  std::int32_t last_m = 0;
  interp::Point3 normal{};
  SpindleThreadWords thread_words;
};

}  // namespace

std::unique_ptr<interp::OwnModes> Language::make_modes() const {
  return std::make_unique<KeptWords>();
}

void Language::keep_modes(interp::OwnModes& into) const {
  auto& kept = static_cast<KeptWords&>(into);
  kept.last_m = last_m;
  kept.normal = normal;
  kept.thread_words = thread_words;
}

void Language::restore_modes(const interp::OwnModes& from) {
  const auto& kept = static_cast<const KeptWords&>(from);
  last_m = kept.last_m;
  normal = kept.normal;
  thread_words = kept.thread_words;
}

void Language::reset(Executor& ex) {
  leave_modes(ex);
  if (ex.data.bit("P0500.6")) {  // CLRG52
    for (auto& axis : ex.axes) axis.zero_local = 0;
    ex.update_zeros();
  }
  levels_.clear();
  write_open_ = false;
}

interp::OwnLanguage::Taken Language::before_block(Executor& ex, Frame&) {
  while (levels_.size() > ex.frames.size()) levels_.pop_back();
  if (curve == nullptr) return Taken::plain;
  if (!curve->next(ex)) curve.reset();
  return Taken::done;
}

bool Language::call_macro(Executor& ex, std::int64_t number, std::int64_t times,
                          const std::array<Value, k2000::kLocals>& locals_of_call, std::uint32_t column) {
  if (number < 1 || number > 9'999)
    return ex.alarm(AlarmReason::program_not_found, column, "O" + std::to_string(number));
  const auto program = static_cast<std::uint32_t>(number);
  if (!ex.call(ex.programs == nullptr ? nullptr : ex.programs->open_number(program), program, times, column))
    return false;
  if (times <= 0) return true;
  Level& called = level(ex);
  called.locals = locals_of_call;
  called.own_locals = true;
  called.arguments.clear();
  called.loops.clear();
  return true;
}

bool Language::take_arguments(Executor& ex, std::array<Value, k2000::kLocals>& into) {
  program::Block& b = ex.block;
  for (const auto& argument : kArguments) {
    if (argument.letter == 'M') {
      if (b.m_count != 0) into[argument.variable] = Value::of_int(to_bcd(b.m[0].tenths / 10));
      continue;
    }
    if (!b.has(argument.letter)) continue;
    const program::Word& word = b[argument.letter];
    Value& local = into[argument.variable];
    if (argument.letter == 'S' || argument.letter == 'T') {
      local = Value::of_int(to_bcd(word.integer()));
    } else if (word.point || ex.pocket) {
      local = Value::of_double(word.value());
    } else if ((kLengths & letter_bit(argument.letter)) != 0) {
      local = Value::of_double(static_cast<double>(ex.nano(word, ex.linear_increment)) / 1e9);
    } else {
      local = Value::of_int(word.digits);
    }
  }
  b.words = 0;
  b.m_count = 0;
  return true;
}

// G65 Pp Ln <arguments>
bool macro_call(Executor& ex) {
  if (!ex.block.has('P')) return ex.alarm(AlarmReason::call_without_p, ex.code_column, "G65");
  const std::int64_t program = ex.whole('P', AlarmReason::program_not_found);
  if (program < 0) return false;
  std::int64_t times = 1;
  if (ex.block.has('L')) {
    times = ex.whole('L', AlarmReason::call_count);
    if (times < 0) return false;
    if (times > ex.dialect.calls.most_repeats)
      return ex.alarm(AlarmReason::call_count, ex.block['L'].column, "L");
  }
  const std::uint32_t column = ex.block['P'].column;
  std::array<Value, k2000::kLocals> locals;
  Language& own = language(ex);
  return own.take_arguments(ex, locals) && own.call_macro(ex, program, times, locals, column);
}

// User G, M and T codes (L20200-L20500).
interp::OwnLanguage::Taken Language::take_block(Executor& ex) {
  program::Block& b = ex.block;
  if (b.m_count != 0) last_m = b.m[0].tenths / 10;
  if (!check_words(ex)) return Taken::done;
  const auto find = [](const std::map<std::int64_t, std::uint32_t>& codes,
                       std::int64_t code) -> std::int64_t {
    const auto found = codes.find(code);
    return found == codes.end() ? -1 : static_cast<std::int64_t>(found->second);
  };
  std::int64_t program = -1;
  std::uint32_t column = 0;
  for (std::size_t i = 0; i < b.g_count && program < 0 && !user_g_.empty(); ++i) {
    if (b.g[i].tenths % 10 != 0) continue;
    program = find(user_g_, b.g[i].tenths / 10);
    column = b.g[i].column;
  }
  for (std::size_t i = 0; i < b.m_count && program < 0 && !user_m_.empty(); ++i) {
    if (b.m[i].tenths % 10 != 0) continue;
    program = find(user_m_, b.m[i].tenths / 10);
    column = b.m[i].column;
    if (program >= 0) b.m_count = 0;
  }
  if (program < 0 && !user_t_.empty() && b.has('T')) {
    program = find(user_t_, b['T'].integer());
    column = b['T'].column;
    if (program >= 0) b.words &= ~letter_bit('T');
  }
  if (program < 0) return Taken::plain;
  std::int64_t times = 1;
  if (b.has('L')) {
    times = ex.whole('L', AlarmReason::call_count);
    if (times < 0) return Taken::done;
  }
  std::array<Value, k2000::kLocals> locals;
  if (take_arguments(ex, locals)) call_macro(ex, program, times, locals, column);
  return Taken::done;
}

// Words that would be silently lost, and codes that a mode refuses.
bool Language::check_words(Executor& ex) {
  const program::Block& b = ex.block;
  constexpr std::int32_t kDwell = 40, kFastMove = 1'530;
  constexpr std::int32_t kMachineCodes[] = {270, 280, 290, 300, 530, 1'530};
  bool keeps_fast_feed = false, spiral = false;
  for (std::size_t i = 0; i < b.g_count; ++i) {
    const std::int32_t code = b.g[i].tenths;
    keeps_fast_feed = keeps_fast_feed || code == kDwell || code == kFastMove;
    for (const std::int32_t machine_code : kMachineCodes) {
      if (code == machine_code && (hypothetical != 0 || thread.on ||
                                   (code >= 530 && ex.surface.now.kind != interp::SurfaceKind::none)))
        return raise(ex, "PS0049", b.g[i].column, std::string("G") + std::to_string(code / 10));
    }
  }
  if (!keeps_fast_feed && fast_feed >= 0) fast_feed = -1;
  if (ex.data.bit("P2500.4")) {  // POD: a point in every length (L7227)
    const std::uint32_t bare = b.words & ~b.pointed & (ex.axis_letters | program::letters("IJKR"));
    for (std::uint32_t mask = bare; mask != 0; mask &= mask - 1) {
      const auto letter = static_cast<char>('A' + std::countr_zero(mask));
      if (!b[letter].point)
        return ex.alarm(AlarmReason::decimal_point, b[letter].column, std::string(1, letter));
    }
  }
  if (const auto digits = ex.data.parameters.find("P0015"); digits != ex.data.parameters.end()) {  // L7209
    const std::int64_t most =
        program::kPowerOfTen[static_cast<std::size_t>(std::clamp(digits->second, 7.0, 9.0))];
    for (std::uint32_t mask = b.words & ex.axis_letters; mask != 0; mask &= mask - 1) {
      const auto letter = static_cast<std::size_t>(std::countr_zero(mask));
      const auto& axis = ex.axes[static_cast<std::size_t>(ex.axis_of[letter])];
      const std::int64_t units = ex.nano(b.word[letter], axis.increment) / axis.increment;
      if (units >= most || units <= -most)
        return ex.alarm(AlarmReason::too_many_digits, b.word[letter].column,
                        std::string(1, static_cast<char>('A' + static_cast<int>(letter))));
    }
  }
  for (std::size_t i = 0; i < b.g_count; ++i) {
    const bool cycle = b.g[i].tenths == 781 || b.g[i].tenths == 1'780;
    if (cycle) thread_words = {};
    if (cycle && (b.words & ex.axis_letters) == 0 && !take_spindle_thread_words(ex)) return false;
  }
  if (b.marked == 0) return true;
  const std::int32_t motion = ex.motion_code == nullptr ? 0 : ex.motion_code->tenths;
  std::int32_t in_force = motion;
  for (std::size_t i = 0; i < b.g_count; ++i) {
    const std::int32_t code = b.g[i].tenths;
    for (const std::int32_t curve_code : {23, 25, 33, 35, 2'030, 2'050, 3'030, 3'050}) {
      if (code == curve_code) in_force = code;
    }
  }
  spiral = in_force % 10 == 3 || in_force % 10 == 5 || in_force >= 2'030;
  const std::uint32_t normals = program::letters("XYZIJK");
  const std::uint32_t known = program::letters("ABCEFPR") | (spiral ? normals : 0u);
  if (const std::uint32_t lost = b.marked & ~known; lost != 0) {
    const auto letter = static_cast<char>('A' + std::countr_zero(lost));
    return raise(ex, "PS0009", b.marked_at(letter).column, std::string("N") + letter);
  }
  return true;
}

bool Language::m_code(Executor& ex, const program::Code& code) {
  const std::int32_t number = code.tenths / 10;
  if (number == 6) {  // M06 calls O(P2510) when CM98 is 1, otherwise it goes to the machine (L9077)
    const double program = ex.data.parameter("P2510", 0);
    if (ex.data.bit("P2500.5") && program > 0) {
      const auto target = static_cast<std::uint32_t>(program);
      return ex.call(ex.programs == nullptr ? nullptr : ex.programs->open_number(target), target, 1,
                     code.column);
    }
    auto& sent = ex.emit<interp::MCode>();
    sent.at = ex.at;
    sent.modal = ex.modal;
    sent.code = number;
    return true;
  }
  if (number == 96 || number == 97) {
    const bool on = number == 96 && ex.switches.origin != interp::ProgramOrigin::dnc;  // not in DNC (L20800)
    return ex.allow_interruption(code, on);
  }
  // M91…M94 Pn: jump when M91I or M93I is 0 or 1 (L8665).
  if (!ex.block.has('P'))
    return ex.alarm(AlarmReason::sequence_not_found, code.column, "M" + std::to_string(number));
  const std::int64_t target = ex.whole('P', AlarmReason::sequence_not_found);
  if (target < 0) return false;
  const bool level_of_input = jump_input(number <= 92 ? 0 : 1);
  const bool wanted = number == 92 || number == 94;
  return level_of_input != wanted || jump(ex, target, ex.block['P'].column);
}

program::LexError Language::Reader::read(const char*& at, const char* end, double& value, bool& is_null) {
  k2000::Parser parser({at, static_cast<std::size_t>(end - at)}, language_, language_.options_);
  Executor& ex = language_.ex_;
  const char* address = at;
  do {
    --address;
  } while (*address == ' ');
  const auto letter = static_cast<char>(*address & ~0x20);
  const auto column = static_cast<std::uint32_t>(address - ex.frames.back().line.text.data()) + 1;
  Value given;
  is_null = false;
  if (!parser.behind_address(given)) {
    language_.wrong_value(ex, parser.error(), column);
    return program::LexError::expression;
  }
  if (given.is_null()) {
    language_.wrong_value(ex, Error::undefined, column);
    return program::LexError::expression;
  }
  at = parser.position();
  value = given.number();
  if (letter == 'G' || letter == 'M' || letter == 'T') {  // these take BCD (L19442)
    const double code = std::floor(value);
    const double binary = from_bcd(code);
    if (binary < 0) {
      language_.wrong_value(ex, Error::bad_argument, column);
      return program::LexError::expression;
    }
    value = binary + (value - code);
    return program::LexError::none;
  }
  // The number becomes one of the address's unit, rounded (L18640); written digits would be cut.
  const bool named = letter >= 'A' && letter <= 'Z';  // a byte that is no letter has no unit
  const std::int8_t axis = named ? ex.axis_of[program::letter_index(letter)] : std::int8_t{-1};
  std::int64_t increment = 0;
  if (axis >= 0) {
    increment = ex.axes[static_cast<std::size_t>(axis)].increment;
  } else if (named && (kLengths & letter_bit(letter)) != 0) {
    increment = ex.linear_increment;
  }
  if (increment != 0 && std::fabs(value) < 1e9) {
    const double unit = static_cast<double>(program::kNano / increment);
    value = std::floor(value * unit + 0.5) / unit;
  }
  return program::LexError::none;
}

}  // namespace headstock::dialects::k2000tc
