// Reading the body of an event. What a message lacks is empty, 0 or nothing, not an error: an older agent
// says less.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace headstock::fleet::body {

inline std::string text(const nlohmann::json& body, const char* key) {
  const auto found = body.find(key);
  return found != body.end() && found->is_string() ? found->get<std::string>() : std::string();
}
inline std::optional<double> real(const nlohmann::json& body, const char* key) {
  const auto found = body.find(key);
  return found != body.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}
inline std::optional<std::int64_t> maybe_integer(const nlohmann::json& body, const char* key) {
  const auto found = body.find(key);
  if (found == body.end() || !found->is_number()) return std::nullopt;
  return found->is_number_float() ? static_cast<std::int64_t>(found->get<double>())
                                  : found->get<std::int64_t>();
}
inline std::int64_t integer(const nlohmann::json& body, const char* key) {
  return maybe_integer(body, key).value_or(0);
}

}  // namespace headstock::fleet::body
