// The OpenAPI 3.1 description, made from the same rows that serve the requests.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "server/api/http/router.hpp"

namespace headstock::api {

nlohmann::json openapi(const Router& router, const std::string& version);
/// The named schemas of schemas.json.
const nlohmann::json& schemas();

}  // namespace headstock::api
