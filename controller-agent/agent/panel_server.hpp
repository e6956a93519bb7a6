// The machine's own panel: a Unix socket in the data folder, which only somebody at this computer can reach. One JSON
// object a line asks, one answers.
#pragma once

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace headstock::agent {

class PanelServer {
 public:
  using Handler = std::function<std::string(const std::string& request)>;
  /// Throws std::runtime_error when the socket cannot be made (path too long, no right).
  PanelServer(boost::asio::io_context& io, std::filesystem::path socket, Handler handler);
  ~PanelServer();
  void start();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace headstock::agent
