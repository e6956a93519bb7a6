#include "db/store.hpp"

#include <gtest/gtest.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

namespace headstock::db {
namespace {

/// Enough for the pool's thread to be behind the caller and before it.
constexpr int kJobs = 2000;

/// What a job was given: says on which threads it ends.
class Given {
 public:
  explicit Given(std::set<std::thread::id>& ended_on) : ended_on_(ended_on) {}
  Given(const Given& other) = default;
  ~Given() { ended_on_.insert(std::this_thread::get_id()); }

 private:
  std::set<std::thread::id>& ended_on_;
};

void run(boost::asio::awaitable<void> everything) {
  boost::asio::io_context io;
  bool over = false;
  boost::asio::co_spawn(io, std::move(everything), [&](std::exception_ptr thrown) {
    over = true;
    if (thrown) std::rethrow_exception(thrown);
  });
  io.run();
  EXPECT_TRUE(over);
}

boost::asio::awaitable<void> jobs_with_something_given(Pool& pool, std::set<std::thread::id>& ended_on) {
  for (int i = 0; i < kJobs; ++i) {
    const auto job = [given = Given(ended_on), i] { return i; };
    EXPECT_EQ(co_await pool.run(job), i);
  }
}

TEST(Pool, WhatAJobWasGivenEndsWithTheCaller) {
  Pool pool(1);
  std::set<std::thread::id> ended_on;
  run(jobs_with_something_given(pool, ended_on));
  pool.join();
  EXPECT_EQ(ended_on, std::set{std::this_thread::get_id()});
}

boost::asio::awaitable<void> jobs_that_throw(Pool& pool) {
  for (int i = 0; i < kJobs; ++i) {
    std::string said;
    const auto job = [i] { throw std::runtime_error("job " + std::to_string(i) + " of a long list of jobs"); };
    try {
      co_await pool.run(job);
    } catch (const std::runtime_error& error) {
      said = error.what();
    }
    EXPECT_EQ(said, "job " + std::to_string(i) + " of a long list of jobs");
  }
}

// Under the thread sanitizer: what was thrown is the caller's alone.
TEST(Pool, WhatAJobThrowsIsReadByTheCaller) {
  Pool pool(2);
  run(jobs_that_throw(pool));
}

}  // namespace
}  // namespace headstock::db
