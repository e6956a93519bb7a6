#include "server/api/http/csv.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace headstock::api {

namespace {

using nlohmann::json;

std::string plain(const json& value) {
  if (value.is_null()) return "";
  if (value.is_string()) return value.get<std::string>();
  return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

void flatten(const json& value, const std::string& name, std::vector<std::pair<std::string, std::string>>& cells) {
  if (value.is_object()) {
    for (const auto& [key, inner] : value.items()) flatten(inner, name.empty() ? key : name + "." + key, cells);
    return;
  }
  if (!value.is_array()) {
    std::string text = plain(value);
    if (value.is_string() && !text.empty() && std::string_view("=+-@\t\r").find(text.front()) != std::string_view::npos)
      text.insert(text.begin(), '\'');
    cells.emplace_back(name, std::move(text));
    return;
  }
  std::string all;
  for (const json& inner : value) all += (all.empty() ? "" : " ") + plain(inner);
  cells.emplace_back(name, std::move(all));
}

void cell(std::string& out, const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

/// `items`, or the only list of objects in the answer.
json* list_in(json& answer) {
  if (!answer.is_object()) return nullptr;
  if (const auto items = answer.find("items"); items != answer.end() && items->is_array()) return &*items;
  for (auto& [name, value] : answer.items())
    if (value.is_array() && !value.empty() && value.front().is_object()) return &value;
  return nullptr;
}

std::string file_name(std::string path) {
  path = path.substr(api_prefix.size());
  std::string name;
  for (const char c : path) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (letter)
      name += c;
    else if (!name.empty() && name.back() != '-')
      name += '-';
  }
  return (name.empty() ? "list" : name) + ".csv";
}

}  // namespace

std::string csv_of(const json& items) {
  std::vector<std::string> names;
  std::vector<std::vector<std::pair<std::string, std::string>>> rows;
  for (const json& item : items) {
    auto& cells = rows.emplace_back();
    flatten(item, item.is_object() ? "" : "value", cells);
    for (const auto& [name, text] : cells)
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  std::string out = "\xEF\xBB\xBF";
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) out += ',';
    cell(out, names[i]);
  }
  out += "\r\n";
  for (const auto& cells : rows) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (i > 0) out += ',';
      const auto found = std::ranges::find(cells, names[i], &std::pair<std::string, std::string>::first);
      if (found != cells.end()) cell(out, found->second);
    }
    out += "\r\n";
  }
  return out;
}

boost::asio::awaitable<Reply> csv_reply(const Route& route, Call& call) {
  json all = json::array();
  const auto asks = [&](std::string_view name) { return std::ranges::find(route.query, name, &Query::name) != route.query.end(); };
  const bool pages = asks("cursor");
  if (pages) call.request.query["limit"] = "1000";
  for (;;) {
    const Reply piece = co_await route.handler(call);
    if (piece.status != 200) throw Refused("bad_request", "format");
    json answer = json::parse(piece.body, nullptr, false);
    json* const list = list_in(answer);
    if (!list) throw Refused("bad_request", "format");
    for (json& item : *list) all.push_back(std::move(item));
    if (all.size() > csv_most_rows) throw Refused("too_many_rows");
    const auto next = answer.find("next");
    if (!pages || next == answer.end() || next->is_null()) break;
    call.request.query["cursor"] = plain(*next);
  }
  Reply reply;
  reply.content_type = "text/csv; charset=utf-8";
  reply.body = csv_of(all);
  reply.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + file_name(call.request.path) + "\"");
  co_return reply;
}

}  // namespace headstock::api
