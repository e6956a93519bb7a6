// The server as one object: the store, the fleet, the agents' side, the interface, put together in the order in which
// they need each other. main.cpp gives it options; tests start it inside their own process.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace headstock::app {

struct Options {
  std::filesystem::path data;
  std::string address = "127.0.0.1";
  std::uint16_t port = 8080;              ///< 0: any free port
  std::string agent_address;              ///< empty: as `address`
  std::uint16_t agent_port = 7878;        ///< 0: any free port
  std::filesystem::path tls_certificate, tls_key;   ///< PEM; empty: made from the data folder's own CA where TLS is used
  bool plain_http = false;                ///< wish for plain HTTP; refused where others could listen
  bool tls = false;                       ///< TLS on loopback too
  std::string database;                   ///< PostgreSQL connection string; empty: SQLite in the data folder
  std::filesystem::path first_sign_in_file;         ///< empty: DATA/first-sign-in
};

/// Why the server cannot start or go on, as one line for the person who starts it, and main's exit status.
class StartError : public std::runtime_error {
 public:
  enum Status : int { other = 1, usage = 2, port_in_use = 3, data_in_use = 4, database = 5, tls = 6 };
  StartError(Status status, const std::string& text) : std::runtime_error(text), status_(status) {}
  Status status() const { return status_; }

 private:
  Status status_;
};

class Shop {
 public:
  /// Opens the data folder and everything in it. Throws StartError.
  explicit Shop(Options options);
  ~Shop();

  /// Listens. Throws StartError.
  void start();
  /// Serves until stop() or, with `signals`, SIGTERM or SIGINT; requests under way are finished.
  enum class Signals { watch, ignore };
  /// @param ready called when everything is in place, the signals too: who reads "ready" may send one.
  void run(Signals signals, const std::function<void()>& ready);
  /// Any thread.
  void stop();

  std::uint16_t port() const;
  std::uint16_t agent_port() const;
  bool secure() const;
  /// `http://127.0.0.1:8080`
  std::string url() const;
  /// The password of the first administrator when this start made it; empty otherwise.
  const std::string& first_password() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace headstock::app
