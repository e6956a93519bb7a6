// Offsets, tool life, parameters, counts and orders as JSON. Used by routes/values.cpp and routes/counts.cpp.
#pragma once

#include "server/api/shapes.hpp"
#include "server/fleet/counts.hpp"
#include "server/fleet/orders.hpp"
#include "server/fleet/tool_life.hpp"
#include "server/fleet/value_sheet.hpp"

namespace headstock::api {

inline json number_json(const std::optional<double>& value) { return value ? json(*value) : json(nullptr); }

json to_json(const dialects::OffsetPage& page, const std::vector<char>& axes);
json to_json(const fleet::LifeNeed& need);

}  // namespace headstock::api
