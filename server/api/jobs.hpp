// Work that may take longer than a client likes to wait: it goes on without the client and is asked for later.
// Network thread only.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <nlohmann/json.hpp>

#include "server/api/http/message.hpp"

namespace headstock::api {

class Jobs {
 public:
  /// At most `kept` jobs are remembered; a finished one for ten minutes at least, unless there are more than that.
  explicit Jobs(boost::asio::io_context& io, std::size_t kept = 256) : io_(io), kept_(kept) {}

  /// Starts `work` and waits for at most `patience`. @return 200 with its result, 202 with `{job,state}` when it takes
  /// longer; what it throws in time is thrown here. Throws Refused("busy") when too many are running.
  boost::asio::awaitable<Reply> run(boost::asio::awaitable<nlohmann::json> work, std::int64_t owner,
                                    std::chrono::milliseconds patience = std::chrono::seconds(3));
  /// `{job,state:"running"|"done"|"failed",result,error}`. Throws Refused("not_found") also for somebody else's.
  nlohmann::json find(std::int64_t id, std::int64_t owner);

 private:
  struct Job;
  void forget_old();

  boost::asio::io_context& io_;
  std::size_t kept_;
  std::int64_t last_id_ = 0;
  std::map<std::int64_t, std::shared_ptr<Job>> jobs_;
};

}  // namespace headstock::api
