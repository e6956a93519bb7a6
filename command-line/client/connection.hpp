// The command line's side of the server's HTTP interface. Blocking; one thread.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

namespace headstock::client {

using nlohmann::json;

/// Exit status of the client's commands.
enum Status : int { ok = 0, usage = 1, refused = 2, unreachable = 3, not_signed_in = 4 };

/// Why a command failed, as one line for the person.
class Failure : public std::runtime_error {
 public:
  Failure(Status status, const std::string& text, json answer = nullptr)
      : std::runtime_error(text), status_(status), answer_(std::move(answer)) {}
  Status status() const { return status_; }
  /// What the server answered, for --json; null when it did not.
  const json& answer() const { return answer_; }

 private:
  Status status_;
  json answer_;
};

struct Server {
  std::string url;                     ///< http://127.0.0.1:8080 or https://…
  std::string token;
  std::filesystem::path ca;            ///< PEM of the CA to trust, besides the system's; may be empty
};

/// How long a server may take to accept a connection.
constexpr long kConnectS = 10;

class Connection {
 public:
  explicit Connection(Server server);

  /// @param path below /api/v1, with its query. Throws Failure for everything but 2xx; its text is the server's, in
  /// the chosen language.
  json get(const std::string& path);
  json send(const std::string& method, const std::string& path, const json& body = json::object());
  /// Streams a file up. @param progress called with bytes sent so far.
  json upload(const std::string& path, const std::filesystem::path& file,
              const std::function<void(std::uint64_t, std::uint64_t)>& progress);
  /// Streams bytes down to `write`.
  void download(const std::string& path, const std::function<void(const char*, std::size_t)>& write);
  /// Live events until `message` returns false. Throws Failure when the server goes.
  void watch(const json& subscription, const std::function<bool(const json&)>& message);

 private:
  std::string url(const std::string& path) const;

  Server server_;
  bool secure_ = false;
  std::string host_, port_;
};

/// For queries: everything but unreserved characters percent-encoded.
std::string encoded(const std::string& text);

}  // namespace headstock::client
