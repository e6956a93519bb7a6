// Where work that may wait for a disk is done, so that the network thread never does: the store's own thread
// with the one database connection, and a small pool for checks, hashes and files.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <exception>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <type_traits>
#include <utility>

#include "db/database.hpp"

namespace headstock::db {

/// Threads that run plain functions for coroutines. `co_await pool.run(f)` resumes where it was called; what
/// `f` throws arrives there too.
class Pool {
 public:
  explicit Pool(unsigned threads) : threads_(threads) {}
  ~Pool() { threads_.join(); }

  template <class F>
  boost::asio::awaitable<std::invoke_result_t<F&>> run(F function) {
    using Result = std::invoke_result_t<F&>;
    using Kept = std::conditional_t<std::is_void_v<Result>, bool, Result>;
    struct Job {
      F function;
      std::optional<Kept> result;
      std::exception_ptr error;
    };
    auto job = std::make_shared<Job>(Job{std::move(function), std::nullopt, nullptr});
    co_await boost::asio::async_initiate<const boost::asio::use_awaitable_t<>&, void()>(
        [this, job](auto handler) {
          auto home = boost::asio::get_associated_executor(handler);
          auto keep = boost::asio::prefer(home, boost::asio::execution::outstanding_work.tracked);
          boost::asio::post(threads_, [job, keep, handler = std::move(handler)]() mutable {
            try {
              if constexpr (std::is_void_v<Result>) {
                job->function();
                job->result = true;
              } else {
                job->result.emplace(job->function());
              }
            } catch (...) {
              job->error = std::current_exception();
            }
            boost::asio::post(keep, std::move(handler));
          });
        },
        boost::asio::use_awaitable);
    if (job->error) std::rethrow_exception(job->error);
    if constexpr (!std::is_void_v<Result>) co_return std::move(*job->result);
  }

  /// Fire and forget, in order when the pool has one thread. `f` must not throw.
  template <class F>
  void post(F function) {
    boost::asio::post(threads_, std::move(function));
  }
  /// Finishes what has been posted; nothing runs afterwards.
  void join() { threads_.join(); }

 private:
  boost::asio::thread_pool threads_;
};

/// The database with its thread. Everything that touches the database goes through run() or post(), in that
/// order.
class Store {
 public:
  /// Opens and migrates DATA/headstock.db on the calling thread. Throws Error with a line for the person who
  /// starts it.
  explicit Store(const std::filesystem::path& data_folder);
  ~Store();

  /// `co_await store.run([=](Database& db) { return list(db); })`: one job, whole; use a Transaction when it
  /// writes.
  template <class F>
  auto run(F function) -> boost::asio::awaitable<std::invoke_result_t<F&, Database&>> {
    return thread_.run([this, function = std::move(function)]() mutable { return function(*database_); });
  }
  /// Writes nobody waits for; a failure is logged with `what`.
  void post(const char* what, std::function<void(Database&)> function);
  /// Blocks the caller until done: for start-up and tests only.
  void now(const std::function<void(Database&)>& function);

 private:
  std::unique_ptr<Database> database_;
  Pool thread_{1};
};

}  // namespace headstock::db
