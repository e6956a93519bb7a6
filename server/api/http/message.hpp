// A request and its reply as the handlers see them: no sockets, no parser, so that a handler can be read and tested
// alone. Everything here lives on the server's io_context thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <boost/asio/awaitable.hpp>
#include <nlohmann/json_fwd.hpp>

namespace headstock::api {

enum class Method : std::uint8_t { get, post, patch, del };
std::string_view to_string(Method method);

/// The header fields that anything here looks at; the rest of a request's header is dropped.
struct Headers {
  std::string authorization, cookie, content_type, x_headstock, if_none_match, range, accept_encoding, origin, host;
};

/// The bytes a client sends after its header, read piece by piece.
class Body {
 public:
  virtual ~Body() = default;
  /// @return bytes written to `into`, 0 at the end. Throws Refused("upload_incomplete") when the client stops in the middle,
  /// Refused("too_large") above the route's limit.
  virtual boost::asio::awaitable<std::size_t> read(char* into, std::size_t at_most) = 0;
  /// Content-Length, if the client said one.
  virtual std::optional<std::uint64_t> announced() const = 0;
};

struct Request {
  Method method = Method::get;
  bool head = false;                             ///< HEAD: answered as GET, without the body
  std::string path;                              ///< percent-decoded, without the query
  std::map<std::string, std::string> query;      ///< percent-decoded
  std::map<std::string, std::string> parameters; ///< `{id}` of the route's pattern
  Headers headers;
  std::string peer;                              ///< address of the client, for the audit trail and the lock-out
  bool secure = false;                           ///< came over TLS
};

/// The body of a long reply, read piece by piece (a program of 100 MB is never in memory).
class ReplyStream {
 public:
  virtual ~ReplyStream() = default;
  virtual std::uint64_t size() const = 0;
  /// @return bytes written to `into`; 0 before `size()` bytes breaks the connection.
  virtual boost::asio::awaitable<std::size_t> read(char* into, std::size_t at_most) = 0;
};

struct Reply {
  unsigned status = 200;
  std::string content_type;
  std::string body;
  std::string_view fixed;                        ///< instead of `body`: bytes that live as long as the program
  std::unique_ptr<ReplyStream> stream;           ///< instead of `body`
  std::vector<std::pair<std::string, std::string>> headers;
  bool cacheable = false;                        ///< false adds `Cache-Control: no-store`
};

Reply json_reply(const nlohmann::json& value, unsigned status = 200);
Reply empty_reply();

/// A handler's way to refuse: becomes `{"error":{code,message,where}}` with the status that errors.cpp has for the
/// code. Thrown, because it ends the handler from any depth of its coroutines.
class Refused : public std::exception {
 public:
  /// @param code a row of the table in errors.cpp. @param where the field, header, line or record it is about.
  /// @param detail appended to both texts (a machine's reason, a file name).
  explicit Refused(std::string code, std::string where = "", std::string detail = "");
  const char* what() const noexcept override { return code_.c_str(); }
  const std::string& code() const { return code_; }
  const std::string& where() const { return where_; }
  const std::string& detail() const { return detail_; }

 private:
  std::string code_, where_, detail_;
};

/// One error as both languages say it.
struct ErrorText {
  std::string_view code;
  unsigned status;
  std::string_view en, zh;
};
/// The row of a code, here or of the services (db/refusal.hpp); an unknown code gives the row "internal".
ErrorText error_text(std::string_view code);
/// The rows of the interface itself.
const std::vector<ErrorText>& all_error_texts();
Reply error_reply(const Refused& refused);

}  // namespace headstock::api
