// The tool life page in JSON: key "tool_life" of the offsets (`--offsets`, and what the agent keeps).
// {"1": {"unit": "uses", "life": 10, "current": 0, "tools": [{"tool": 10, "offset": 1, "used": 3}]},
//  "2": {"unit": "seconds", "life": 3600, "tools": [{"tool": 20, "h": 2, "d": 2, "used": 12.5, "skipped":
//  true}]}}
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/tool_life.hpp"

namespace headstock::tools {

/// @return empty, or what is wrong and where; `into` is changed only when all is right.
std::string read_life(const nlohmann::json& object, LifeTable& into);
nlohmann::json life_to_json(const LifeTable& table);

}  // namespace headstock::tools
