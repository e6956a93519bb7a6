// What a macro variable holds: a real number, or <null> (never assigned).
#pragma once

#include <limits>

#include "dialects/alarm_reason.hpp"

namespace headstock::macro {

/// <null> is the only NaN of the language: every operation that would make another one is an alarm.
inline constexpr double kNull = std::numeric_limits<double>::quiet_NaN();
constexpr bool is_null(double value) {
  return value != value;
}
/// Arithmetic and ordering take <null> as 0 (0i-D 14.1 L13573); only EQ, NE and plain assignment tell them apart.
constexpr double or_zero(double value) {
  return is_null(value) ? 0.0 : value;
}

using Fault = dialects::AlarmReason;

/// How an evaluation or an access to a variable ended.
enum class Status : unsigned char {
  ok,
  standstill,  ///< the value is only true when everything before has been carried out: ask again then
  wait,        ///< the program's source has no data yet
  fault
};
struct Result {
  Status status = Status::ok;
  Fault fault = Fault::count_;

  static Result failed(Fault reason) { return {Status::fault, reason}; }
  static Result later() { return {Status::standstill, Fault::count_}; }
  bool ok() const { return status == Status::ok; }
};

}  // namespace headstock::macro
