#include "server/api/jobs.hpp"

#include <gtest/gtest.h>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "server/api/routes/routes.hpp"

namespace headstock::api {
namespace {

namespace asio = boost::asio;
using asio::awaitable;
using nlohmann::json;
using namespace std::chrono_literals;

awaitable<json> at_once(json value) { co_return value; }
awaitable<json> refusing() {
  throw Refused("too_large");
  co_return json();
}
/// Finishes when the gate is cancelled.
awaitable<json> gated(asio::steady_timer& gate) {
  gate.expires_at(asio::steady_timer::time_point::max());
  co_await gate.async_wait(asio::as_tuple(asio::use_awaitable));
  co_return json{{"ok", true}};
}

/// Runs one request to its end. What it throws arrives here.
Reply answer_of(asio::io_context& io, Jobs& jobs, awaitable<json> work, std::chrono::milliseconds patience) {
  Reply reply;
  std::exception_ptr failed;
  bool done = false;
  asio::co_spawn(io, jobs.run(std::move(work), 1, patience), [&](std::exception_ptr error, Reply got) {
    failed = error;
    reply = std::move(got);
    done = true;
  });
  io.restart();
  while (!done) io.run_one();
  if (failed) std::rethrow_exception(failed);
  return reply;
}

TEST(Jobs, WhatIsQuickIsAnsweredAtOnce) {
  asio::io_context io;
  Jobs jobs(io);
  const auto reply = answer_of(io, jobs, at_once({{"ok", true}}), 10s);
  EXPECT_EQ(reply.status, 200u);
  EXPECT_EQ(json::parse(reply.body), (json{{"ok", true}}));
}

TEST(Jobs, WhatIsRefusedInTimeIsRefused) {
  asio::io_context io;
  Jobs jobs(io);
  EXPECT_THROW(answer_of(io, jobs, refusing(), 10s), Refused);
}

TEST(Jobs, WhatTakesLongerIsAskedForLater) {
  asio::io_context io;
  Jobs jobs(io);
  asio::steady_timer gate(io);
  const auto reply = answer_of(io, jobs, gated(gate), 1ms);
  EXPECT_EQ(reply.status, 202u);
  const auto id = json::parse(reply.body).at("job").get<std::int64_t>();
  EXPECT_EQ(jobs.find(id, 1).at("state"), "running");
  EXPECT_THROW(jobs.find(id, 2), Refused) << "somebody else's";
  EXPECT_THROW(jobs.find(id + 1, 1), Refused);
  gate.cancel();
  io.restart();
  io.run();
  EXPECT_EQ(jobs.find(id, 1).at("state"), "done");
  EXPECT_EQ(jobs.find(id, 1).at("result").at("ok"), true);
}

TEST(Jobs, AreBounded) {
  asio::io_context io;
  Jobs jobs(io, 2);
  asio::steady_timer gates[2] = {asio::steady_timer(io), asio::steady_timer(io)};
  answer_of(io, jobs, gated(gates[0]), 1ms);
  answer_of(io, jobs, gated(gates[1]), 1ms);
  EXPECT_THROW(answer_of(io, jobs, at_once({}), 1s), Refused);
  gates[0].cancel();
  gates[1].cancel();
  io.restart();
  io.run();
  EXPECT_EQ(answer_of(io, jobs, at_once({}), 1s).status, 200u) << "finished ones make room";
}

TEST(Times, AreReadAndRefused) {
  EXPECT_EQ(parse_time("1970-01-01T00:00:01.500Z"), 1500);
  EXPECT_EQ(parse_time("1970-01-02"), 86'400'000);
  EXPECT_EQ(parse_time("2026-01-01T10:20Z"), 1767262800000);
  EXPECT_EQ(parse_time("1767225600000"), 1767225600000);
  for (const char* bad : {"", "x", "2026-13-01", "2026-02-30", "2026-01-01T25:00Z", "2026-01-01T10:00:00+01:00", "2026-1-1"})
    EXPECT_FALSE(parse_time(bad)) << bad;
}

}  // namespace
}  // namespace headstock::api
