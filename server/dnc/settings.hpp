// A port's settings as they are stored and edited: JSON with the names of the manuals' terms.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "protocol/serial/protocols.hpp"
#include "protocol/tape/filter.hpp"

namespace headstock::dnc {

struct PortSettings {
  serial::LinkSettings link;
  tape::FilterOptions filter;  ///< on the way out; the stored revision is never touched
};
nlohmann::json to_json(const PortSettings& settings);
/// What is not named keeps the value of the protocol's row. Throws db::Refusal{bad_value, field}.
PortSettings settings_from(const nlohmann::json& json);

/// "(GET=*)" in what a control punched asks for the program "O*"; `*` stands for letters, digits, `_`, `-`,
/// `.`.
struct RequestRule {
  enum Action { send, list };
  std::string pattern;
  Action action = send;
  std::string name;  ///< of send: with `*`; of list: the O number of the answer
};
nlohmann::json to_json(const std::vector<RequestRule>& rules);
/// Throws db::Refusal{bad_value, "rules"}.
std::vector<RequestRule> rules_from(const nlohmann::json& json);

/// What a punched text asks for by a port's rules.
struct Wanted {
  const RequestRule* rule = nullptr;  ///< nullptr: nothing
  std::string name;
};
/// Looks at the first 2,000 characters; spaces do not count and letters may be small.
Wanted wanted(std::string_view text, const std::vector<RequestRule>& rules);

}  // namespace headstock::dnc
