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

/// Named, or nothing in it that a copy byte by byte would break.
template <class F>
inline constexpr bool kSurvivesAwait =
    std::is_lvalue_reference_v<F> || std::is_trivially_copyable_v<std::decay_t<F>>;

/// Threads that run plain functions for coroutines. `co_await pool.run(f)` resumes where it was called; what
/// `f` throws arrives there too.
class Pool {
 public:
  explicit Pool(unsigned threads) : threads_(threads) {}
  ~Pool() { threads_.join(); }

  /// A lambda that captures strings and the like by value must have a name: `const auto work = […]; co_await
  /// run(work);` GCC 12 copies temporaries of a co_await expression byte by byte, and such captures do not
  /// survive that.
  template <class F>
  boost::asio::awaitable<std::invoke_result_t<std::decay_t<F>&>> run(F&& function) {
    static_assert(kSurvivesAwait<F>,
                  "GCC 12: give this lambda a name before the co_await expression, then pass the name");
    return carry_out(std::make_shared<Job<std::decay_t<F>>>(std::forward<F>(function)));
  }

  /// Fire and forget, in order when the pool has one thread. `f` must not throw.
  template <class F>
  void post(F function) {
    boost::asio::post(threads_, std::move(function));
  }
  /// Finishes what has been posted; nothing runs afterwards.
  void join() { threads_.join(); }

 private:
  template <class F>
  struct Job {
    using Result = std::invoke_result_t<F&>;
    template <class G>
    explicit Job(G&& the_function) : function(std::forward<G>(the_function)) {}

    void operator()() noexcept {
      try {
        if constexpr (std::is_void_v<Result>) {
          function();
          result.emplace(true);
        } else {
          result.emplace(function());
        }
      } catch (...) {
        error = std::current_exception();
      }
    }

    F function;
    std::optional<std::conditional_t<std::is_void_v<Result>, bool, Result>> result;
    std::exception_ptr error;
  };

  /// Hands the job to the pool and resumes the caller on its own executor when it is done.
  template <class F>
  struct Start {
    boost::asio::thread_pool& threads;
    std::shared_ptr<Job<F>> job;

    template <class Handler>
    void operator()(Handler handler) const {
      auto home = boost::asio::prefer(boost::asio::get_associated_executor(handler),
                                      boost::asio::execution::outstanding_work.tracked);
      boost::asio::post(threads, [home, work = job, back = std::move(handler)]() mutable {
        (*work)();
        boost::asio::post(home, std::move(back));
      });
    }
  };

  template <class F>
  boost::asio::awaitable<typename Job<F>::Result> carry_out(std::shared_ptr<Job<F>> job) {
    Start<F> start{threads_, job};
    co_await boost::asio::async_initiate<const boost::asio::use_awaitable_t<>&, void()>(
        std::move(start), boost::asio::use_awaitable);
    if (job->error) std::rethrow_exception(job->error);
    if constexpr (!std::is_void_v<typename Job<F>::Result>) co_return std::move(*job->result);
  }

  boost::asio::thread_pool threads_;
};

/// The database with its thread. Everything that touches the database goes through run() or post(), in that
/// order.
class Store {
 public:
  /// Opens and migrates DATA/headstock.db, or the PostgreSQL database that `connection` names, on the calling
  /// thread. Throws Error with a line for the person who starts it.
  explicit Store(const std::filesystem::path& data_folder, const std::string& connection = {});
  ~Store();

  /// `co_await store.run([=](Database& db) { return list(db); })`: one job, whole; use a Transaction when it
  /// writes.
  template <class F>
  auto run(F&& function) -> boost::asio::awaitable<std::invoke_result_t<std::decay_t<F>&, Database&>> {
    static_assert(kSurvivesAwait<F>,
                  "GCC 12: give this lambda a name before the co_await expression, then pass the name");
    WithDatabase<std::decay_t<F>> job{std::forward<F>(function), *database_};
    return thread_.run(job);
  }
  /// Writes nobody waits for; a failure is logged with `what`.
  void post(const char* what, std::function<void(Database&)> function);
  /// Blocks the caller until done: for start-up and tests only.
  void now(const std::function<void(Database&)>& function);

 private:
  template <class F>
  struct WithDatabase {
    F function;
    Database& database;
    auto operator()() { return function(database); }
  };

  std::unique_ptr<Database> database_;
  Pool thread_{1};
};

}  // namespace headstock::db
