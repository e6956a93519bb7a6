// What makes one controller's macro language differ from another's, as data. Part of a Dialect; constant.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace headstock::macro {

/// A range of common variables.
struct CommonRange {
  std::uint16_t first = 1, last = 0;  ///< 100…999; empty when last < first
  bool retained = false;              ///< kept over power-off
};

/// A G or M code, or a row of them, that calls a program (parameters hold the code).
struct CodeCalls {
  std::string_view first_parameter;  ///< "6050": its value is the code; 0 or absent: none
  int count = 0;                     ///< parameters in a row, each one code
  std::uint32_t first_program = 0;   ///< program of the first one
};
/// A block of codes: number, program and count each in a parameter (0i-D 14.5.4).
struct CodeBlockCalls {
  std::string_view code, program, count;
};

struct Rules {
  bool statements = false;  ///< assignments, IF, GOTO, WHILE; expressions behind addresses
  std::uint16_t locals = 33;
  std::array<CommonRange, 2> common{};
  bool retained_start_at_zero = false;  ///< on a new machine; otherwise <null>
  std::string_view clear_locals_parameter;  ///< bit: locals do not survive reset ("S173.1"); empty: never
  std::string_view keep_volatile_parameter;  ///< bit: #100… survive reset ("6001#6")
  std::string_view clear_volatile_parameter;  ///< bit: they do not survive ("S173.0"); empty: always cleared
  std::string_view protect_first = {}, protect_last = {};  ///< parameters: write-protected commons

  // ---- expressions
  unsigned most_brackets = 5;                      ///< nested, those of functions counted
  bool nine_is_indirect = false;                   ///< #9200 is #[#200]
  unsigned most_digits = 12;                       ///< of a constant
  std::string_view signed_angles_parameter;        ///< bit: ASIN −90…90, ATAN[]/[] −180…180 ("6004#0")
  std::string_view eight_digits_parameter;         ///< bit: values keep 8 digits ("6008#0")
  std::string_view converted_arguments_parameter;  ///< bit: ADP may not be used ("6007#4")

  // ---- statements
  int most_loops = 3;                ///< DO numbers 1…, and their nesting
  std::uint32_t most_goto = 99'999;  ///< GOTO targets

  std::string_view single_block_parameter;  ///< bit: single block stops at statements ("6000#5")
  std::string_view switched_single_block_parameter;  ///< bit: it does unless #3003 says not to ("6000#7")
  std::string_view fast_goto_first_parameter;   ///< bit: GOTO looks at the first 20 numbers passed ("6000#1")
  std::string_view fast_goto_recent_parameter;  ///< bit: GOTO looks at the last 30 passed ("6000#4")

  // ---- #3000
  std::string_view alarm_prefix = "MC";
  int alarm_digits = 4;
  int alarm_base = 3000, alarm_most = 200;
  std::string_view alarm_plain_parameter;  ///< bit: n itself, without the base ("6008#1")
  int alarm_plain_most = 4'095;
  std::size_t most_message = 26;  ///< characters of #3000 and #3006

  // ---- calls
  int macro_nesting = 5, all_nesting = 15;
  std::int64_t most_repeats = 999'999'999, most_code_repeats = 99'999'999;
  bool type_two = true;  ///< I J K in groups
  std::string_view sequence_call_parameter;  ///< bit: M98 P Q begins at sequence number Q ("6005#0")
  std::string_view type_one_parameter;  ///< bit: never in groups ("6008#7")
  bool macro_calls = false;  ///< G65 P
  bool h_codes = false;      ///< G65 with H is an operation, not a call (GSK)
  std::uint32_t whole_arguments = 0;  ///< letters whose arguments have no decimals (see program::letters)
  std::string_view typed_arguments_parameter;  ///< bit: pocket decimals are not for arguments ("3452#7")
  std::string_view decimal_d_parameter;  ///< bit: D as an argument has decimals after all ("6019#2")
  bool modal_calls = false;             ///< G66/G67
  std::string_view lone_cancel_parameter;  ///< bit: G67 without G66 is no alarm ("6000#0")
  CodeCalls g_macros, m_macros, m_subs;
  CodeBlockCalls g_macro_block, m_macro_block, m_sub_block;
  std::string_view t_sub_parameter;  ///< bit: T calls t_sub_program
  std::uint32_t t_sub_program = 9'000;
  std::uint16_t t_sub_variable = 149;
  std::array<std::string_view, 2> address_parameters{};  ///< ASCII code of a letter that calls a sub-program
  std::array<std::uint32_t, 2> address_programs{};
  std::array<std::uint16_t, 2> address_variables{};
  std::string_view nested_codes_parameter;  ///< bit: codes call inside code calls too ("6008#6")
  std::string_view external_m_parameter;    ///< M code of the external call ("6030"); 0: 198
  bool external_call = false;               ///< M198
  bool interruption = false;                 ///< M96 P, M97
  std::string_view interruption_codes_parameter, interruption_on_parameter, interruption_off_parameter;
  std::string_view interruption_same_locals_parameter;

  // ---- output
  std::string_view external_in_mdi_parameter;  ///< bit: M198 works in MDI ("11630#1")
  bool printing = false;                 ///< POPEN, BPRNT, DPRNT, PCLOS
  std::string_view print_plain_parameter;  ///< bit: no spaces for zeros and the plus sign ("6001#1")
  std::string_view print_cr_parameter;     ///< bit: CR after LF ("6001#4")
  bool names = false;                      ///< SETVN, [#NAME], [#_SYSTEM]
};

}  // namespace headstock::macro
