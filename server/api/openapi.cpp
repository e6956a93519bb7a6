#include "server/api/openapi.hpp"

#include <algorithm>
#include <cctype>
#include <set>

#include <nlohmann/json.hpp>

#include "generated/api_schemas.hpp"

namespace headstock::api {

using nlohmann::json;

namespace {

json reference(const std::string& schema) { return {{"$ref", "#/components/schemas/" + schema}}; }

json content(const std::string& schema) { return {{"application/json", {{"schema", reference(schema)}}}}; }

json octets() {
  return {{"application/octet-stream", {{"schema", {{"type", "string"}, {"contentEncoding", "binary"}}}}}};
}

json parameters_of(const Route& route) {
  json parameters = json::array();
  std::size_t at = 0;
  while ((at = route.pattern.find('{', at)) != std::string::npos) {
    const auto end = route.pattern.find('}', at);
    const auto name = route.pattern.substr(at + 1, end - at - 1);
    parameters.push_back({{"name", name},
                          {"in", "path"},
                          {"required", true},
                          {"schema", {{"type", name == "name" ? "string" : "integer"}}}});
    at = end;
  }
  for (const auto& query : route.query)
    parameters.push_back({{"name", query.name},
                          {"in", "query"},
                          {"required", false},
                          {"description", query.about},
                          {"schema", {{"type", query.type}}}});
  return parameters;
}

/// Statuses of refusals, each with the codes that come with it.
json refusals_of(const Route& route) {
  std::vector<std::string> codes = route.errors;
  if (route.role != Role::none) codes.insert(codes.end(), {"unauthenticated", "forbidden"});
  if (route.takes == Takes::json) codes.insert(codes.end(), {"bad_json", "bad_request", "bad_content_type", "too_large"});
  if (!route.query.empty()) codes.emplace_back("bad_request");
  if (route.pattern.find('{') != std::string::npos) codes.emplace_back("not_found");
  if (route.role != Role::none && route.method != Method::get) codes.emplace_back("cross_site");
  std::map<unsigned, std::set<std::string>> by_status;
  for (const auto& code : codes) by_status[error_text(code).status].insert(code);
  json responses = json::object();
  for (const auto& [status, names] : by_status) {
    std::string list;
    for (const auto& name : names) list += (list.empty() ? "" : ", ") + name;
    responses[std::to_string(status)] = {{"description", list}, {"content", content("Error")}};
  }
  return responses;
}

json operation_of(const Route& route) {
  std::string id = std::string(to_string(route.method)) + route.pattern;
  std::ranges::transform(id, id.begin(), [](unsigned char c) { return std::isalnum(c) ? static_cast<char>(std::tolower(c)) : '_'; });
  json responses = refusals_of(route);
  json success = {{"description", "success"}};
  if (route.response == "bytes")
    success["content"] = octets();
  else if (!route.response.empty())
    success["content"] = content(route.response);
  responses[std::to_string(route.takes == Takes::web_socket ? 101u : route.status)] = success;
  json operation = {{"operationId", id},
                    {"summary", route.summary},
                    {"parameters", parameters_of(route)},
                    {"responses", responses},
                    {"x-role", to_string(route.role)}};
  if (route.role == Role::none) operation["security"] = json::array();
  if (route.takes == Takes::bytes) operation["requestBody"] = {{"required", true}, {"content", octets()}};
  if (route.takes == Takes::json && !route.request.empty())
    operation["requestBody"] = {{"required", true}, {"content", content(route.request)}};
  if (route.takes == Takes::web_socket) operation["x-websocket"] = true;
  return operation;
}

}  // namespace

const json& schemas() {
  static const json parsed = json::parse(api_schemas_json);
  return parsed;
}

json openapi(const Router& router, const std::string& version) {
  json paths = json::object();
  for (const auto& route : router.routes()) {
    std::string method(to_string(route.method));
    std::ranges::transform(method, method.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    paths[route.pattern][method] = operation_of(route);
  }
  return {{"openapi", "3.1.0"},
          {"info",
           {{"title", "Headstock"},
            {"version", version},
            {"description", "Errors, roles and the WebSocket are described in server/api/README.md."},
            {"license", {{"name", "Apache-2.0"}, {"identifier", "Apache-2.0"}}}}},
          {"servers", json::array({{{"url", api_prefix}}})},
          {"paths", paths},
          {"components",
           {{"schemas", schemas()},
            {"securitySchemes",
             {{"bearer", {{"type", "http"}, {"scheme", "bearer"}}},
              {"cookie", {{"type", "apiKey"}, {"in", "cookie"}, {"name", "headstock_session"}}}}}}},
          {"security", json::array({{{"bearer", json::array()}}, {{"cookie", json::array()}}})}};
}

}  // namespace headstock::api
