// G10 L52 … G11: parameters written by the program; G10 L50 … G11: pitch error data (0i-D 4.1).
#include <cmath>

#include "dialects/catalogue.hpp"
#include "interpreter/executor.hpp"
#include "interpreter/handlers.hpp"

namespace headstock::interp::handlers {
namespace {

constexpr std::uint32_t kDataWords = program::letters("PR");
constexpr int kBits = 8;

// N_ [P_] R_ and nothing else.
bool only_data(Executor& ex) {
  const program::Block& b = ex.block;
  if (b.g_count != 0 || b.m_count != 0 || b.has_number) {
    const std::uint32_t column = b.g_count != 0   ? b.g[0].column
                                 : b.m_count != 0 ? b.m[0].column
                                                  : b.number_column;
    return ex.alarm(AlarmReason::parameter_format, column, "G M O");
  }
  if (const std::uint32_t wrong = b.words & ~kDataWords; wrong != 0) {
    for (char letter = 'A'; letter <= 'Z'; ++letter) {
      if ((wrong & program::letter_bit(letter)) != 0)
        return ex.alarm(AlarmReason::parameter_format, b[letter].column, std::string(1, letter));
    }
  }
  if (!b.has_sequence) return ex.alarm(AlarmReason::parameter_word_missing, 1, "N");
  if (!b.has('R')) return ex.alarm(AlarmReason::parameter_word_missing, b.sequence_column, "R");
  if (b['R'].point) return ex.alarm(AlarmReason::parameter_format, b['R'].column, "R");
  return true;
}

void write(Executor& ex, const std::string& key, double value) {
  const double before = ex.data.parameter(key);
  ex.data.parameters[key] = value;
  if (before != value) ex.report_change("parameter/" + key, before, value);
}

bool is_axis_type(const Executor& ex, std::int64_t number) {
  for (const auto& range : ex.dialect.modes.axis_parameters) {
    if (number >= range.first && number <= range.last) return true;
  }
  return false;
}

bool is_spindle_type(const Executor& ex, std::int64_t number) {
  for (const auto& range : ex.dialect.modes.spindle_parameters) {
    if (number >= range.first && number <= range.last) return true;
  }
  return false;
}

// The text's bits: R00000100 sets bit 2 and clears the others.
bool write_bits(Executor& ex, const std::string& number, const std::string& suffix) {
  const program::Word& word = ex.block['R'];
  std::int64_t left = word.digits;
  if (left < 0) return ex.alarm(AlarmReason::parameter_sign, word.column, "R");
  for (int bit = 0; bit < kBits; ++bit, left /= 10) {
    if (left % 10 > 1) return ex.alarm(AlarmReason::parameter_range, word.column, "R");
    write(ex, number + '#' + std::to_string(bit) + suffix, static_cast<double>(left % 10));
  }
  return left == 0 || ex.alarm(AlarmReason::parameter_range, word.column, "R");
}

// No.1220…1226 are the work zero offsets themselves (0i-D: external, G54…G59).
bool work_origin(Executor& ex, std::uint32_t number, const std::string& suffix, double mm) {
  constexpr std::uint32_t kExternal = 1220, kLast = 1226;
  if (number < kExternal || number > kLast) return false;
  const std::size_t axis = *ex.axis_named(suffix[1]);
  double& cell =
      number == kExternal ? ex.data.work_external[axis] : ex.data.work[number - kExternal - 1][axis];
  const double before = cell;
  cell = mm;
  const std::string place = number == kExternal ? "EXT" : "G" + std::to_string(53 + number - kExternal);
  if (before != mm) ex.report_change("work/" + place + suffix, before, mm);
  ex.update_zeros();
  return true;
}

bool parameter_line(Executor& ex) {
  if (!only_data(ex)) return false;
  const program::Block& b = ex.block;
  const std::string number = std::to_string(b.sequence);
  const std::string_view profile = ex.dialect.profile;
  // Bits are listed one by one ("3404#2"), numbers of less than four digits with leading zeros ("0001#1").
  const std::string padded = number.size() < 4 ? std::string(4 - number.size(), '0') + number : number;
  dialects::Parameter row;
  bool bits = false;
  for (int bit = 0; bit < kBits && !bits; ++bit)
    bits = dialects::find_parameter(profile, padded + '#' + std::to_string(bit), row);
  if (!bits && !dialects::find_parameter(profile, padded, row) && !is_axis_type(ex, b.sequence))
    return ex.alarm(AlarmReason::parameter_number, b.sequence_column, "N" + number);

  std::string suffix;
  std::int64_t increment = ex.linear_increment;
  if (is_axis_type(ex, b.sequence)) {
    if (!b.has('P')) return ex.alarm(AlarmReason::parameter_axis_missing, b.sequence_column, "N" + number);
    const std::int64_t p = ex.whole('P', AlarmReason::parameter_axis);
    if (p < 0) return false;
    if (p < 1 || p > static_cast<std::int64_t>(ex.axes.size()))
      return ex.alarm(AlarmReason::parameter_axis, b['P'].column, "P" + std::to_string(p));
    const ProgramAxis& axis = ex.axes[static_cast<std::size_t>(p - 1)];
    suffix = std::string("/") + axis.name;
    increment = axis.increment;
  } else if (b.has('P') && !is_spindle_type(ex, b.sequence)) {
    return ex.alarm(AlarmReason::parameter_no_axis, b['P'].column, "P");
  }
  if (bits) {
    if (!write_bits(ex, padded, suffix)) return false;
  } else {
    // Real numbers are written as whole numbers of their own least unit (N1322 P3 R4500 → 4.500 under IS-B).
    const bool real = row.unit.starts_with("mm") || row.unit.starts_with("deg") ||
                      (b.sequence >= 1220 && b.sequence <= 1226);
    const auto value = static_cast<double>(b['R'].digits);
    const double in_units = real ? value * static_cast<double>(increment) / 1e9 : value;
    if (work_origin(ex, b.sequence, suffix, in_units)) return true;
    write(ex, number + suffix, real ? value * static_cast<double>(increment) / 1e9 : value);
  }
  ex.take_parameters();
  return true;
}

// N point + 10000, R.
bool pitch_line(Executor& ex) {
  if (!only_data(ex)) return false;
  const program::Block& b = ex.block;
  if (b.has('P')) return ex.alarm(AlarmReason::parameter_no_axis, b['P'].column, "P");
  // Points 0…1023, and 3000…4023 of the other direction (0i-D parameters 3620…).
  const bool point =
      (b.sequence >= 10'000 && b.sequence <= 11'023) || (b.sequence >= 13'000 && b.sequence <= 14'023);
  if (!point)
    return ex.alarm(AlarmReason::parameter_number, b.sequence_column, "N" + std::to_string(b.sequence));
  constexpr std::int64_t kMost = 7;  // increments of one point
  const std::int64_t value = b['R'].digits;
  if (value > kMost || value < -kMost) return ex.alarm(AlarmReason::parameter_range, b['R'].column, "R");
  write(ex, std::to_string(b.sequence), static_cast<double>(value));
  return true;
}

}  // namespace

bool parameter_input(Executor& ex) {
  ex.data_input.line = parameter_line;
  return true;
}

bool pitch_input(Executor& ex) {
  ex.data_input.line = pitch_line;
  return true;
}

}  // namespace headstock::interp::handlers
