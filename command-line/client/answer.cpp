#include "command-line/client/answer.hpp"

#include "command-line/client/output.hpp"

namespace headstock::client {

namespace {

std::string message_of(unsigned status, const json& answer) {
  if (answer.is_object() && answer.contains("error") && answer["error"].is_object()) {
    const auto& error = answer["error"];
    const auto& texts = error.value("message", json::object());
    std::string text = texts.value(chinese() ? "zh" : "en", error.value("code", std::string("error")));
    if (error.contains("where") && error["where"].is_string()) text += " (" + error["where"].get<std::string>() + ")";
    return text;
  }
  return say("the server answered with status ", "服务器返回状态 ") + std::to_string(status);
}

json parsed(const std::string& body) {
  if (body.empty()) return nullptr;
  auto value = json::parse(body, nullptr, false);
  return value.is_discarded() ? json(nullptr) : value;
}

}  // namespace

json demand_success(unsigned status, const std::string& body) {
  json answer = parsed(body);
  if (status >= 200 && status < 300) return answer;
  if (status == 401)
    throw Failure(not_signed_in, message_of(status, answer) + say("; use: headstock login", "；请使用 headstock login"), answer);
  throw Failure(refused, message_of(status, answer), answer);
}

Failure cannot_connect(const std::string& url, const std::string& why) {
  return Failure(unreachable, say("cannot reach the server at ", "无法连接服务器 ") + url + ": " + why);
}

Failure not_trusted(const std::string& why) {
  return Failure(unreachable, say("the server's certificate is not trusted; give the shop's CA (DATA/pki on the server) with login --ca: ",
                                  "服务器证书不受信任；请用 login --ca 指定车间 CA 证书（位于服务器的 DATA/pki）：") + why);
}

Failure bad_certificate_file(const std::string& file, const std::string& why) {
  return Failure(usage, say("cannot read the certificate ", "无法读取证书 ") + file + ": " + why);
}

}  // namespace headstock::client
