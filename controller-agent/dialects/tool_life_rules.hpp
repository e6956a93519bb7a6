// What a dialect says about tool life management: parameter numbers and the way a program commands it.
#pragma once

#include <cstdint>
#include <string_view>

namespace headstock::dialects {

struct ToolLifeRules {
  enum class Form : std::uint8_t {
    none,     ///< the control has no tool life management
    turret,   ///< T group 99 chooses and counts, T group 88 cancels the offset (0i-D 10.2.3 T)
    changer,  ///< T above the ignore number chooses, M06 counts; H99 and D99 (0i-D 10.2.3 M)
  };
  Form form = Form::none;
  std::string_view enable_parameter;  ///< bit: life management is on
  std::int64_t most_groups = 128;
  std::string_view most_groups_parameter = {};  ///< 0: most_groups
  /// Two bits: groups are a half, a quarter, an eighth of the most, with 4, 8, 16 tools each; both set: all,
  /// with 2.
  std::string_view split_low_parameter = {}, split_high_parameter = {};
  std::size_t tools_in_group = 16;  ///< without those bits
  std::int64_t most_uses = 65'535, most_minutes = 4'300;
  std::string_view by_time_parameter = {};       ///< bit: groups count time unless Q says otherwise
  std::string_view tenths_word_parameter = {};   ///< bit: L is tenths of a second, not minutes
  std::string_view tenths_count_parameter = {};  ///< bit: counted every 0.1 s, not every second
  std::string_view round_up_parameter = {};      ///< bit: less than a second counts as one
  std::string_view per_offset_parameter = {};    ///< bit: several offsets of a tool have a life each
  std::string_view every_use_parameter =
      {};  ///< bit: every command of a group counts, not the first of a run
  std::string_view next_group_parameter =
      {};                                  ///< bit: a spent group hands over to the next one with life left
  std::string_view ignore_parameter = {};  ///< changer: T up to this number are tools
  std::string_view next_in_change_parameter =
      {};  ///< changer, bit: T beside M06 is the next group, not the returned
  std::string_view count_in_change_parameter =
      {};  ///< changer, bit: T beside M06 is chosen and counted by it
  std::string_view change_without_t_parameter = {};     ///< changer, bit: then M06 without T is no alarm
  std::string_view any_returned_parameter = {};         ///< changer, bit: the returned group is not compared
  std::string_view h_parameter = {}, d_parameter = {};  ///< changer: numbers instead of H99 and D99
  std::string_view restart_parameter = {},
                   restart_large_parameter = {};  ///< M code that lets groups count again
  std::string_view stop_at_m99_parameter = {};  ///< bit: M99 of the main program stops when a group is spent
  std::string_view notice_uses_parameter = {},
                   notice_time_parameter = {};   ///< remaining life that is announced
  std::string_view notice_equal_parameter = {};  ///< bit: announced only while it is just that
};

}  // namespace headstock::dialects
