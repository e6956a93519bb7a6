// A compiled macro expression: a little stack program without any text left in it. Compiled once, evaluated often.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "macro/value.hpp"
#include "macro/variables.hpp"

namespace headstock::macro {

enum class Op : std::uint8_t {
  constant,
  variable,  ///< #n, n in `number`
  indirect,  ///< #[…]
  named,     ///< [#NAME]: names[number]
  indexed,   ///< [#_NAME[…]]: `number` + (index − 1) × `step`, index 1…`most` (0…`most`−1 when `from_zero`)
  bit,       ///< [#_M_SBK]: bit `step` of #`number`
  negate,
  add,
  subtract,
  multiply,
  divide,
  modulo,
  bit_and,
  bit_or,
  bit_xor,
  eq,
  ne,
  gt,
  ge,
  lt,
  le,
  sin,
  cos,
  tan,
  asin,
  acos,
  atan,
  atan2,
  sqrt,
  abs,
  bin,
  bcd,
  round,
  fix,
  fup,
  ln,
  exp,
  pow,
  adp  ///< ADP[#n]
};

struct Instruction {
  Op op = Op::constant;
  bool from_zero = false;
  std::uint16_t step = 0, most = 0;
  std::uint32_t number = 0;
  double constant = 0;
};

/// Deepest stack a compiled expression may need.
inline constexpr int kMostStack = 64;

struct Expression {
  std::vector<Instruction> code;
  std::vector<std::string> names;
  bool empty() const { return code.empty(); }
};

/// What is assigned: #n, #[…], [#NAME], [#_NAME[…]], [#_M_SBK].
struct Place {
  Instruction how;   ///< variable, indirect, named, indexed or bit: where the number comes from
  Expression index;  ///< of indirect and indexed
  std::string name;  ///< of named
};

/// @param steps what ROUND rounds to: 1 in statements; least increments a unit behind an address (0i-D L17041).
Result evaluate(const Expression& expression, Variables& variables, double steps, double& value);

/// The number of the variable a place means.
Result locate(const Place& place, Variables& variables, std::uint32_t& number);

}  // namespace headstock::macro
