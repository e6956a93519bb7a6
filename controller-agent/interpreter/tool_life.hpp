// Tool life in a program: what T, M06, H99, D99 and G10 L3 do (0i-D 10.2). The groups are in
// MachineData::tool_life; the rules of choosing and counting in tools/tool_life.hpp.
//
// Uses are counted when the block is carried out that chooses (turret) or changes (changer) the tool; cutting
// time is told by whoever carries out the moves, see Interpreter::tool_cut_for.
#pragma once

#include <cstdint>
#include <vector>

#include "dialects/tool_life_rules.hpp"

namespace headstock::interp {

struct Executor;

/// State of one path.
struct ToolLife {
  static constexpr std::int32_t kNone = 0, kOrdinary = -1;  ///< no group; a tool outside life management

  std::int32_t in_use = kNone;  ///< group whose tool is counted
  std::size_t in_use_entry = 0;
  std::int32_t chosen = kNone;  ///< changer: by T, for the next M06
  std::size_t chosen_entry = 0;
  std::vector<std::int32_t> commanded;  ///< groups of this run: they neither count nor choose again
  double tenths_left = 0;               ///< cutting time that is not a whole interval yet
  std::int64_t unreported = 0;          ///< tenths counted since the last report

  enum class Input : std::uint8_t { none, all, change, remove };
  Input input = Input::none;  ///< G10 L3, P1, P2
  std::int32_t input_group = kNone;
};

namespace tool_life {

inline constexpr std::int64_t kTenthsAMinute = 600;  ///< life in minutes is kept in tenths of a second

bool is_on(const Executor& ex);

/// Groups, and tools in each, as the parameters divide the memory.
struct Limits {
  std::int64_t groups;
  std::size_t tools;
};
Limits limits(const Executor& ex);

/// A T word: turns the number of a group into the T word of its tool. @return false after an alarm.
bool take_t(Executor& ex, std::int64_t& value, std::uint32_t column);

/// An M code on its way to the machine: M06 and the restart code. @return false after an alarm.
bool take_m(Executor& ex, std::int32_t code, std::uint32_t column);

/// H99 or D99: the number registered for the tool in use. @return false after an alarm.
bool take_offset(Executor& ex, char letter, std::int64_t& number, std::uint32_t column);

/// The handler of G10 L3; the blocks up to G11 are data.
bool input(Executor& ex);

void begin_run(Executor& ex);  ///< cycle start from the reset state
void end_run(Executor& ex);    ///< M02, M30: spent groups are announced
void leave(Executor& ex);      ///< reset: counting ends
/// M99 of the main program. @return true when the run has to stop for new tools.
bool stops_at_m99(Executor& ex);

/// The tool in use has cut for this long.
void cut_for(Executor& ex, double seconds);

}  // namespace tool_life
}  // namespace headstock::interp
