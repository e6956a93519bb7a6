#include "command-line/client/connection.hpp"

#include <algorithm>
#include <cctype>
#include <exception>
#include <fstream>
#include <istream>
#include <memory>
#include <utility>

#include <curl/curl.h>

#include "command-line/client/answer.hpp"
#include "command-line/client/output.hpp"

namespace headstock::client {

namespace {

constexpr long kStalledS = 120;   // a check may take long; the server answers 202 well before
constexpr std::size_t kErrorBytes = 65536;

struct Closes {
  void operator()(CURL* handle) const { curl_easy_cleanup(handle); }
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};

/// What is called from within the library must not throw through it.
template <class F>
bool kept(std::exception_ptr& failed, F&& run) {
  try {
    std::forward<F>(run)();
    return true;
  } catch (...) {
    failed = std::current_exception();
    return false;
  }
}

/// One request and its answer.
class Exchange {
 public:
  Exchange(const Server& server, const std::string& method, const std::string& url) : server_(server), handle_(curl_easy_init()) {
    if (!handle_) throw Failure(unreachable, "libcurl");
    set(CURLOPT_URL, url.c_str());
    set(CURLOPT_CUSTOMREQUEST, method.c_str());
    set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
    set(CURLOPT_USERAGENT, "headstock");
    set(CURLOPT_PROXY, "");   // a server stands in the shop: never through the proxy of the environment
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_CONNECTTIMEOUT, kConnectS);
    set(CURLOPT_LOW_SPEED_LIMIT, 1L);
    set(CURLOPT_LOW_SPEED_TIME, kStalledS);
    set(CURLOPT_ERRORBUFFER, error_);
    if (!server.ca.empty()) set(CURLOPT_CAINFO, server.ca.c_str());   // besides the system's folder of certificates
    header("X-Headstock: 1");
    header("Expect:");
    if (!server.token.empty()) header("Authorization: Bearer " + server.token);
    set(CURLOPT_WRITEFUNCTION, &Exchange::arrived);
    set(CURLOPT_WRITEDATA, this);
  }

  void header(const std::string& line) { headers_.reset(curl_slist_append(headers_.release(), line.c_str())); }

  void body(const std::string& text) {
    header(text.empty() ? "Content-Type:" : "Content-Type: application/json");
    set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(text.size()));
    set(CURLOPT_COPYPOSTFIELDS, text.c_str());
  }

  void body(std::istream& file, std::uint64_t size, const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    file_ = &file;
    size_ = size;
    progress_ = &progress;
    header("Content-Type: application/octet-stream");
    set(CURLOPT_POST, 1L);
    set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(size));
    set(CURLOPT_UPLOAD_BUFFERSIZE, 256L * 1024);
    set(CURLOPT_READFUNCTION, &Exchange::wanted);
    set(CURLOPT_READDATA, this);
  }

  /// @param sink takes what a good answer holds; without it the answer is returned.
  json run(const std::function<void(const char*, std::size_t)>& sink = {}) {
    sink_ = &sink;
    set(CURLOPT_HTTPHEADER, headers_.get());
    const auto ended = curl_easy_perform(handle_.get());
    if (failed_) std::rethrow_exception(failed_);
    // A server that refuses early closes while the file is still being sent; its answer has arrived all the same.
    const bool answered = status() >= 400 && (ended == CURLE_SEND_ERROR || ended == CURLE_RECV_ERROR);
    if (ended != CURLE_OK && !answered) throw failure(ended);
    return demand_success(static_cast<unsigned>(status()), text_);
  }

 private:
  template <class Value>
  void set(CURLoption option, Value value) {
    curl_easy_setopt(handle_.get(), option, value);
  }

  long status() const {
    long value = 0;
    curl_easy_getinfo(handle_.get(), CURLINFO_RESPONSE_CODE, &value);
    return value;
  }

  Failure failure(CURLcode code) const {
    const std::string why = error_[0] != '\0' ? error_ : curl_easy_strerror(code);
    if (code == CURLE_PEER_FAILED_VERIFICATION) return not_trusted(why);
    if (code == CURLE_SSL_CACERT_BADFILE) return bad_certificate_file(server_.ca.string(), why);
    return cannot_connect(server_.url, why);
  }

  static std::size_t arrived(char* bytes, std::size_t, std::size_t count, void* user) {
    auto& self = *static_cast<Exchange*>(user);
    const auto status = self.status();
    const bool to_sink = *self.sink_ && status >= 200 && status < 300;
    const bool good = kept(self.failed_, [&] {
      if (to_sink)
        (*self.sink_)(bytes, count);
      else if (!*self.sink_ || self.text_.size() < kErrorBytes)
        self.text_.append(bytes, count);
    });
    return good ? count : 0;
  }

  static std::size_t wanted(char* into, std::size_t, std::size_t room, void* user) {
    auto& self = *static_cast<Exchange*>(user);
    std::size_t got = 0;
    const bool good = kept(self.failed_, [&] {
      const auto part = std::min<std::uint64_t>(room, self.size_ - self.sent_);
      self.file_->read(into, static_cast<std::streamsize>(part));
      got = static_cast<std::size_t>(self.file_->gcount());
      if (got == 0 && part > 0) throw Failure(usage, say("the file became shorter while it was sent", "发送过程中文件变短"));
      self.sent_ += got;
      if (got > 0 && *self.progress_) (*self.progress_)(self.sent_, self.size_);
    });
    return good ? got : CURL_READFUNC_ABORT;
  }

  const Server& server_;
  std::unique_ptr<CURL, Closes> handle_;
  std::unique_ptr<curl_slist, Closes> headers_;
  char error_[CURL_ERROR_SIZE] = {};
  std::string text_;
  std::exception_ptr failed_;
  const std::function<void(const char*, std::size_t)>* sink_ = nullptr;
  std::istream* file_ = nullptr;
  std::uint64_t size_ = 0, sent_ = 0;
  const std::function<void(std::uint64_t, std::uint64_t)>* progress_ = nullptr;
};

}  // namespace

std::string encoded(const std::string& text) {
  static constexpr char digits[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || c == '-' || c == '.' || c == '_' || c == '~') {
      out += c;
    } else {
      out += '%';
      out += digits[byte >> 4];
      out += digits[byte & 15];
    }
  }
  return out;
}

Connection::Connection(Server server) : server_(std::move(server)) {
  std::string_view rest = server_.url;
  if (rest.starts_with("https://")) {
    secure_ = true;
    rest.remove_prefix(8);
  } else if (rest.starts_with("http://")) {
    rest.remove_prefix(7);
  } else {
    throw Failure(usage, say("the server's address must begin with http:// or https://: ", "服务器地址须以 http:// 或 https:// 开头：") + server_.url);
  }
  rest = rest.substr(0, rest.find('/'));
  const auto close = rest.find(']');
  const auto colon = rest.rfind(':');
  const bool has_port = colon != std::string_view::npos && (close == std::string_view::npos || colon > close);
  port_ = has_port ? std::string(rest.substr(colon + 1)) : (secure_ ? "443" : "80");
  host_ = std::string(rest.substr(0, has_port ? colon : rest.size()));
  if (host_.size() > 2 && host_.front() == '[') host_ = host_.substr(1, host_.size() - 2);
}

std::string Connection::url(const std::string& path) const {
  const bool v6 = host_.find(':') != std::string::npos;
  return (secure_ ? "https://" : "http://") + (v6 ? "[" + host_ + "]" : host_) + ":" + port_ + "/api/v1" + path;
}

json Connection::get(const std::string& path) {
  return Exchange(server_, "GET", url(path)).run();
}

json Connection::send(const std::string& method, const std::string& path, const json& body) {
  Exchange exchange(server_, method, url(path));
  if (!body.is_null() || method == "POST" || method == "PUT") exchange.body(body.is_null() ? std::string() : body.dump());
  return exchange.run();
}

json Connection::upload(const std::string& path, const std::filesystem::path& file,
                        const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  std::ifstream in(file, std::ios::binary);
  if (error || !in) throw Failure(usage, say("cannot read ", "无法读取 ") + file.string());
  Exchange exchange(server_, "POST", url(path));
  exchange.body(in, size, progress);
  return exchange.run();
}

void Connection::download(const std::string& path, const std::function<void(const char*, std::size_t)>& write) {
  Exchange(server_, "GET", url(path)).run(write);
}

}  // namespace headstock::client
