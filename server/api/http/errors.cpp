#include <nlohmann/json.hpp>

#include "db/refusal.hpp"
#include "server/api/http/message.hpp"

namespace headstock::api {

namespace {

/// What the interface itself refuses. What the services refuse has its words in db/refusal.cpp.
const std::vector<ErrorText> texts = {
    {"bad_request", 400, "The request is not understood", "请求无法识别"},
    {"bad_json", 400, "The body is not valid JSON", "请求内容不是有效的 JSON"},
    {"cross_site", 403, "The header X-Headstock: 1 is missing", "缺少请求头 X-Headstock: 1"},
    {"method_not_allowed", 405, "This address does not take that method", "该地址不支持此方法"},
    {"refused", 409, "The machine refused", "机床拒绝"},
    {"timeout", 408, "The request took too long to arrive", "请求接收超时"},
    {"length_required", 411, "The length of the body is not known", "未知请求内容长度"},
    {"bad_content_type", 415, "The body must be application/json", "请求内容必须为 application/json"},
    {"bad_range", 416, "There are no such bytes", "请求的字节范围无效"},
    {"web_socket_only", 426, "This address speaks WebSocket only", "该地址仅支持 WebSocket"},
    {"header_too_large", 431, "The header of the request is too large", "请求头过大"},
    {"internal", 500, "Something went wrong in the server; its log has the details", "服务器内部错误，详见日志"},
    {"busy", 503, "Too many connections; try again in a moment", "连接数过多，请稍后再试"},
    {"database_locked", 503, "The database is busy; try again in a moment", "数据库繁忙，请稍后再试"},
    {"database_lost", 503, "The connection to the database is lost; try again in a moment", "与数据库的连接已断开，请稍后再试"},
    {"too_many_rows", 413, "Too many rows; choose a shorter time", "数据行过多，请缩短时间范围"},
    {"disk_full", 507, "The server's disk is full; nothing was stored", "服务器磁盘已满；未保存任何内容"},
};

unsigned status_of(db::RefusalKind kind) {
  switch (kind) {
    case db::RefusalKind::invalid: return 400;
    case db::RefusalKind::unauthenticated: return 401;
    case db::RefusalKind::forbidden: return 403;
    case db::RefusalKind::not_found: return 404;
    case db::RefusalKind::conflict: return 409;
    case db::RefusalKind::too_large: return 413;
    case db::RefusalKind::too_many: return 429;
    case db::RefusalKind::unavailable: return 503;
  }
  return 500;
}

}  // namespace

Refused::Refused(std::string code, std::string where, std::string detail)
    : code_(std::move(code)), where_(std::move(where)), detail_(std::move(detail)) {}

const std::vector<ErrorText>& all_error_texts() { return texts; }

ErrorText error_text(std::string_view code) {
  const ErrorText* internal = nullptr;
  for (const auto& text : texts) {
    if (text.code == code) return text;
    if (text.code == "internal") internal = &text;
  }
  if (const auto* refusal = db::refusal_text(code))
    return {refusal->code, status_of(refusal->kind), refusal->en, refusal->zh};
  return *internal;
}

Reply error_reply(const Refused& refused) {
  const auto text = error_text(refused.code());
  std::string en(text.en), zh(text.zh);
  if (!refused.detail().empty()) {
    en += ": " + refused.detail();
    zh += "：" + refused.detail();
  }
  nlohmann::json error = {{"code", text.code}, {"message", {{"en", en}, {"zh", zh}}}};
  if (refused.where().empty())
    error["where"] = nullptr;
  else
    error["where"] = refused.where();
  return json_reply(nlohmann::json{{"error", error}}, text.status);
}

Reply json_reply(const nlohmann::json& value, unsigned status) {
  Reply reply;
  reply.status = status;
  reply.content_type = "application/json; charset=utf-8";
  // Texts of programs and machines may hold any bytes; what is not UTF-8 is shown as U+FFFD rather than refused.
  reply.body = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return reply;
}

Reply empty_reply() {
  Reply reply;
  reply.status = 204;
  return reply;
}

}  // namespace headstock::api
