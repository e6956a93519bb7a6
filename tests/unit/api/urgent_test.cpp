// Stop has its own path: it does not wait for a store that is stuck.
#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <nlohmann/json.hpp>

#include "server/api/http/dispatch.hpp"

namespace headstock::api {
namespace {

namespace asio = boost::asio;
using asio::awaitable;

struct NoBody final : BoundedBody {
  awaitable<std::size_t> read(char*, std::size_t) override { co_return 0; }
  std::optional<std::uint64_t> announced() const override { return 0; }
};

/// A shop whose store never answers.
struct Stuck {
  Stuck() {
    const auto act = [this](Call& call) -> awaitable<Reply> {
      stopped_by = call.who.user;
      co_return json_reply(nlohmann::json::object());
    };
    std::vector<Route> routes;
    routes.push_back({.method = Method::post, .pattern = "/stop", .role = Role::operate, .handler = act, .urgent = true});
    routes.push_back({.method = Method::post, .pattern = "/start", .role = Role::operate, .handler = act});
    router.add(std::move(routes));
    host.authenticate = [this](std::string) -> awaitable<Principal> {
      asio::steady_timer never(io, asio::steady_timer::time_point::max());
      co_await never.async_wait(asio::use_awaitable);
      co_return Principal{};
    };
    host.known = [](const std::string& token) -> std::optional<Principal> {
      if (token != "seen" && token != "viewer") return std::nullopt;
      Principal who;
      who.user = token;
      who.role = token == "seen" ? Role::operate : Role::viewer;
      return who;
    };
  }
  /// @return the status; 0: it still waits.
  unsigned ask(const std::string& path, const std::string& token) {
    unsigned status = 0;
    Request request;
    request.method = Method::post;
    request.path = "/api/v1" + path;
    request.headers.authorization = "Bearer " + token;
    request.headers.content_type = "application/json";
    NoBody body;
    asio::co_spawn(
        io,
        [&]() -> awaitable<void> { status = (co_await dispatch(router, host, Limits{}, request, body)).reply.status; },
        [](std::exception_ptr) {});
    io.poll();
    return status;
  }

  asio::io_context io;
  Router router;
  WebHost host;
  std::string stopped_by;
};

TEST(Urgent, StopDoesNotWaitForTheStore) {
  Stuck shop;
  EXPECT_EQ(shop.ask("/stop", "seen"), 200u);
  EXPECT_EQ(shop.stopped_by, "seen");
}

TEST(Urgent, ButNeedsAPersonWhoMay) {
  Stuck shop;
  EXPECT_EQ(shop.ask("/stop", "viewer"), 403u);
}

TEST(Urgent, AndNothingElseGoesPast) {
  {
    Stuck shop;
    EXPECT_EQ(shop.ask("/start", "seen"), 0u);
  }
  {
    Stuck shop;
    EXPECT_EQ(shop.ask("/stop", "nobody"), 0u) << "who was never seen is looked up";
  }
}

}  // namespace
}  // namespace headstock::api
