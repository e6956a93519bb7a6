#include "server/integrations/deliver.hpp"

#include <curl/curl.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "db/hash.hpp"
#include "db/time.hpp"

namespace headstock::integrations {
namespace {

using nlohmann::json;

constexpr long kTimeoutS = 20;

struct Easy {
  Easy() : handle(curl_easy_init()) {}
  ~Easy() {
    curl_slist_free_all(list);
    curl_easy_cleanup(handle);
  }
  Easy(const Easy&) = delete;
  Easy& operator=(const Easy&) = delete;
  void add(const std::string& line) { list = curl_slist_append(list, line.c_str()); }
  CURL* handle;
  curl_slist* list = nullptr;
};

struct Reading {
  const std::string& text;
  std::size_t at = 0;
};

std::size_t read_some(char* into, std::size_t size, std::size_t count, void* user) {
  auto& reading = *static_cast<Reading*>(user);
  const std::size_t part = std::min(size * count, reading.text.size() - reading.at);
  std::copy_n(reading.text.data() + reading.at, part, into);
  reading.at += part;
  return part;
}

std::size_t ignore(char*, std::size_t size, std::size_t count, void*) {
  return size * count;
}

void once() {
  static const CURLcode ready = curl_global_init(CURL_GLOBAL_DEFAULT);
  (void)ready;
}

std::string base64(const std::string& text) {
  std::string out(4 * ((text.size() + 2) / 3) + 1, '\0');
  const int length = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                                     reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
  out.resize(static_cast<std::size_t>(length));
  return out;
}

/// RFC 2047, in words short enough for a header line and without cutting a character.
std::string encoded_words(const std::string& text) {
  std::string out, piece;
  const auto flush = [&] {
    if (piece.empty()) return;
    if (!out.empty()) out += "\r\n ";
    out.append("=?UTF-8?B?").append(base64(piece)).append("?=");
    piece.clear();
  };
  for (std::size_t at = 0; at < text.size();) {
    std::size_t end = at + 1;
    while (end < text.size() && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) ++end;
    if (piece.size() + end - at > 42) flush();
    piece += text.substr(at, end - at);
    at = end;
  }
  flush();
  return out;
}

std::string in_lines(const std::string& encoded) {
  std::string out;
  for (std::size_t at = 0; at < encoded.size(); at += 76) out.append(encoded, at, 76).append("\r\n");
  return out;
}

/// No line end may come from data: it would be a header of its own.
std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\r' || c == '\n') c = ' ';
  return text;
}

std::string hmac_hex(const std::string& secret, const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned length = 0;
  HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()), reinterpret_cast<const unsigned char*>(text.data()),
       text.size(), digest.data(), &length);
  return db::to_hex({reinterpret_cast<const char*>(digest.data()), length});
}

std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace

std::string mail_text(const MailServer& server, const Mail& mail, std::int64_t at_ms, const std::string& id) {
  const std::time_t seconds = static_cast<std::time_t>(at_ms / 1000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 64> date{};
  std::strftime(date.data(), date.size(), "%a, %d %b %Y %H:%M:%S +0000", &utc);
  std::string out;
  out.append("From: ").append(one_line(server.from)).append("\r\nTo: ").append(one_line(mail.to));
  out.append("\r\nSubject: ").append(encoded_words(one_line(mail.subject))).append("\r\nDate: ").append(date.data());
  out.append("\r\nMessage-ID: <").append(id).append("@headstock>\r\nMIME-Version: 1.0\r\n");
  out.append("Auto-Submitted: auto-generated\r\nContent-Type: text/plain; charset=utf-8\r\n");
  out.append("Content-Transfer-Encoding: base64\r\n\r\n").append(in_lines(base64(mail.text)));
  return out;
}

Mail mail_of(const std::string& body, const std::string& to, const std::string& link) {
  const json facts = json::parse(body, nullptr, false);
  if (!facts.is_object()) return {to, "Headstock", body};
  const std::string step = text_of(facts, "step");
  if (step == "test") return {to, "Headstock: test / 测试", "This is a test message of Headstock.\r\n这是 Headstock 的测试消息。\r\n"};
  const json machine = facts.value("machine", json::object()), text = facts.value("text", json::object());
  const std::string name = text_of(machine, "name"), code = text_of(facts, "code");
  Mail mail;
  mail.to = to;
  mail.subject = (step == "escalation" ? "[!!] " : "[!] ") + name + ": " + code + " " + text_of(text, "zh") + " / " + text_of(text, "en");
  auto& out = mail.text;
  const auto line = [&out](const std::string& what, const std::string& value) {
    if (!value.empty()) out += what + ": " + value + "\r\n";
  };
  if (step == "escalation")
    out += "Nobody has acknowledged this alarm in time. / 该报警未在规定时间内确认。\r\n\r\n";
  line("Machine / 机床", name);
  line("Alarm / 报警", code);
  line("  ", text_of(text, "zh"));
  line("  ", text_of(text, "en"));
  line("Since / 开始", text_of(facts, "since"));
  line("Program / 程序", text_of(facts, "program"));
  line("Block / 程序段", text_of(facts, "block"));
  line("Rule / 规则", text_of(facts, "rule"));
  if (facts.value("storm", false))
    out += "\r\nMany alarms: further ones are only in the list for ten minutes. / 报警过多：十分钟内其余报警仅见于列表。\r\n";
  if (!link.empty()) out += "\r\nAcknowledge / 确认: " + link + "\r\n";
  return mail;
}

std::string send_mail(const MailServer& server, const Mail& mail) {
  if (server.url.empty()) return "no mail server is set up";
  once();
  Easy easy;
  const std::string id = db::random_hex(16), text = mail_text(server, mail, db::now_ms(), id);
  Reading reading{text};
  std::string from = server.from;
  if (const auto open = from.find('<'); open != std::string::npos) from = from.substr(open);
  curl_easy_setopt(easy.handle, CURLOPT_URL, server.url.c_str());
  curl_easy_setopt(easy.handle, CURLOPT_PROTOCOLS_STR, "smtp,smtps");
  curl_easy_setopt(easy.handle, CURLOPT_USE_SSL, static_cast<long>(server.demand_tls ? CURLUSESSL_ALL : CURLUSESSL_TRY));
  if (!server.user.empty()) {
    curl_easy_setopt(easy.handle, CURLOPT_USERNAME, server.user.c_str());
    curl_easy_setopt(easy.handle, CURLOPT_PASSWORD, server.password.c_str());
  }
  curl_easy_setopt(easy.handle, CURLOPT_MAIL_FROM, from.c_str());
  easy.add(mail.to);
  curl_easy_setopt(easy.handle, CURLOPT_MAIL_RCPT, easy.list);
  curl_easy_setopt(easy.handle, CURLOPT_READFUNCTION, read_some);
  curl_easy_setopt(easy.handle, CURLOPT_READDATA, &reading);
  curl_easy_setopt(easy.handle, CURLOPT_UPLOAD, 1L);
  curl_easy_setopt(easy.handle, CURLOPT_TIMEOUT, kTimeoutS);
  curl_easy_setopt(easy.handle, CURLOPT_NOSIGNAL, 1L);
  const CURLcode result = curl_easy_perform(easy.handle);
  if (result == CURLE_OK) return "";
  long code = 0;
  curl_easy_getinfo(easy.handle, CURLINFO_RESPONSE_CODE, &code);
  return std::string(curl_easy_strerror(result)) + (code > 0 ? " (" + std::to_string(code) + ")" : "");
}

std::string call_webhook(const std::string& url, const std::string& body, const std::string& secret) {
  once();
  Easy easy;
  easy.add("Content-Type: application/json; charset=utf-8");
  easy.add("Expect:");
  if (!secret.empty()) easy.add("X-Headstock-Signature: sha256=" + hmac_hex(secret, body));
  curl_easy_setopt(easy.handle, CURLOPT_URL, url.c_str());
  curl_easy_setopt(easy.handle, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy.handle, CURLOPT_HTTPHEADER, easy.list);
  curl_easy_setopt(easy.handle, CURLOPT_USERAGENT, "headstock");
  curl_easy_setopt(easy.handle, CURLOPT_POSTFIELDS, body.c_str());
  curl_easy_setopt(easy.handle, CURLOPT_POSTFIELDSIZE, static_cast<long>(body.size()));
  curl_easy_setopt(easy.handle, CURLOPT_WRITEFUNCTION, ignore);
  curl_easy_setopt(easy.handle, CURLOPT_TIMEOUT, kTimeoutS);
  curl_easy_setopt(easy.handle, CURLOPT_NOSIGNAL, 1L);
  const CURLcode result = curl_easy_perform(easy.handle);
  if (result != CURLE_OK) return curl_easy_strerror(result);
  long status = 0;
  curl_easy_getinfo(easy.handle, CURLINFO_RESPONSE_CODE, &status);
  return status >= 200 && status < 300 ? "" : "the answer was " + std::to_string(status);
}

}  // namespace headstock::integrations
