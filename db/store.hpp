// Where work that may wait for a disk is done, so that the network thread never does: the store's own thread
// with the one database connection, and a small pool for checks, hashes and files.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/thread_pool.hpp>
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
    using Result = std::invoke_result_t<std::decay_t<F>&>;
    return answer(std::unique_ptr<Answer<Result>>(
        std::make_unique<Job<std::decay_t<F>, Result>>(std::forward<F>(function))));
  }

  /// Fire and forget, in order when the pool has one thread. `f` must not throw.
  void post(std::function<void()> function);
  /// Finishes what has been posted; nothing runs afterwards.
  void join() { threads_.join(); }

 private:
  // A job in three layers, so that the machinery of threads and coroutines is compiled once, a coroutine once
  // for each kind of result, and for each of several hundred functions only what calls it.
  struct Work {
    virtual ~Work() = default;
    virtual void work() noexcept = 0;
  };
  template <class Result>
  struct Answer : Work {
    std::optional<std::conditional_t<std::is_void_v<Result>, bool, Result>> result;
    std::exception_ptr error;
  };
  template <class F, class Result>
  struct Job final : Answer<Result> {
    template <class G>
    explicit Job(G&& the_function) : function(std::forward<G>(the_function)) {}

    void work() noexcept override {
      try {
        if constexpr (std::is_void_v<Result>) {
          function();
          this->result.emplace(true);
        } else {
          this->result.emplace(function());
        }
      } catch (...) {
        this->error = std::current_exception();
      }
    }

    F function;
  };

  /// Hands the work to the pool and resumes the caller on its own executor when it is done. The work stays the caller's:
  /// what it holds ends on the caller's thread, never on the pool's behind the caller's back.
  boost::asio::awaitable<void> done(Work& work);

  template <class Result>
  boost::asio::awaitable<Result> answer(std::unique_ptr<Answer<Result>> job) {
    co_await done(*job);
    if (job->error) std::rethrow_exception(job->error);
    if constexpr (!std::is_void_v<Result>) co_return std::move(*job->result);
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
