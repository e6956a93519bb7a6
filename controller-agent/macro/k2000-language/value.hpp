// What a K2000TC macro variable holds: nothing (NULL), or a number with a type as in C. Types decide: 5/2
// is 2.
#pragma once

#include <cstdint>
#include <optional>

namespace headstock::k2000 {

/// In the order of promotion (K2000TC L18840-L18900).
enum class Type : std::uint8_t { null, int_, uint, long_, ulong, float_, double_ };

struct Value {
  Type type = Type::null;
  std::int64_t whole = 0;  ///< of the integer types; ULONG as its bit pattern
  double real = 0;         ///< of FLOAT (a float's value) and DOUBLE

  static Value of_int(std::int64_t value);  ///< cut to 32 bits
  static Value of_uint(std::uint64_t value);
  static Value of_double(double value) { return {Type::double_, 0, value}; }
  static Value of_float(double value);

  bool is_null() const { return type == Type::null; }
  bool is_real() const { return type >= Type::float_; }
  bool is_whole() const { return type >= Type::int_ && type <= Type::ulong; }
  double number() const;  ///< NULL is 0
  bool truth() const { return is_real() ? real != 0 : whole != 0; }
  /// The value as an integer when its type is one.
  std::optional<std::int64_t> integer() const {
    return is_whole() ? std::optional<std::int64_t>(whole) : std::nullopt;
  }
};

/// C's conversion; a real out of range becomes the nearest value of the type.
Value convert(const Value& value, Type to);

/// Binary operators in the order of the manual's table (L19650).
enum class Operator : std::uint8_t {
  multiply,
  divide,
  add,
  subtract,
  shift_left,
  shift_right,
  less,
  less_equal,
  greater,
  greater_equal,
  equal,
  not_equal,
  bit_and,
  bit_xor,
  bit_or,
  logical_and,
  logical_or
};

/// Why a statement failed. NULL and everything else have different alarms.
enum class Error : std::uint8_t {
  none,
  syntax,
  null_used,       ///< NULL in an expression
  undefined,       ///< a variable without a value in an expression
  whole_needed,    ///< a bit operation, a jump or a condition with a real number
  divide_by_zero,  ///< of integers; reals give INF
  bad_argument,    ///< of a function
  no_variable,     ///< no such variable, or it may not be written
  array_size,      ///< arrays of different sizes
  later            ///< true only when everything before has been carried out: ask again then
};

/// @return none, null_used, whole_needed or divide_by_zero.
Error apply(Operator op, const Value& left, const Value& right, Value& result);
enum class Sign : std::uint8_t { plus, minus, logical_not, bit_not };
Error apply(Sign sign, const Value& value, Value& result);

}  // namespace headstock::k2000
