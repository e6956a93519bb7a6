// Shapes that the two files of port routes share.
#pragma once

#include <nlohmann/json.hpp>

#include "db/port_store.hpp"

namespace headstock::api {

nlohmann::json port_transfer_json(const db::PortTransferRow& row);

/// 0 and "" are null on the wire.
inline nlohmann::json maybe_id(std::int64_t id) { return id == 0 ? nlohmann::json(nullptr) : nlohmann::json(id); }
inline nlohmann::json maybe_text(const std::string& text) {
  return text.empty() ? nlohmann::json(nullptr) : nlohmann::json(text);
}

/// A piece of a list, each row by `shape`.
template <class Row, class Shape>
nlohmann::json list_json(const db::Listed<Row>& list, Shape&& shape) {
  nlohmann::json items = nlohmann::json::array();
  for (const auto& row : list.items) items.push_back(shape(row));
  return {{"items", std::move(items)},
          {"next", list.next ? nlohmann::json(std::to_string(*list.next)) : nlohmann::json(nullptr)}};
}

}  // namespace headstock::api
