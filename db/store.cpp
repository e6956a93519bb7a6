#include "db/store.hpp"

#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <condition_variable>
#include <mutex>

#include "db/migrations.hpp"
#include "protocol/process/log.hpp"

namespace headstock::db {
namespace {

namespace asio = boost::asio;

std::unique_ptr<Database> open_in(const std::filesystem::path& folder, const std::string& connection) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw Error(Problem::unreadable,
                folder.string() + ": cannot make the data folder (" + error.message() + ")");
  auto database = connection.empty() ? open_sqlite(folder / "headstock.db") : open_postgres(connection);
  migrate(*database);
  return database;
}

}  // namespace

void Pool::post(std::function<void()> function) {
  asio::post(threads_, std::move(function));
}

asio::awaitable<void> Pool::done(Work& work) {
  const auto begin = [this, &work](auto handler) {
    auto home =
        asio::prefer(asio::get_associated_executor(handler), asio::execution::outstanding_work.tracked);
    // `back` keeps the caller and its work alive.
    asio::post(threads_, [home, &work, back = std::move(handler)]() mutable {
      work.work();
      asio::post(home, std::move(back));
    });
  };
  co_await asio::async_initiate<const asio::use_awaitable_t<>&, void()>(begin, asio::use_awaitable);
}

Store::Store(const std::filesystem::path& data_folder, const std::string& connection)
    : database_(open_in(data_folder, connection)) {}

Store::~Store() {
  thread_.join();
}

void Store::post(const char* what, std::function<void(Database&)> function) {
  thread_.post([this, what, function = std::move(function)] {
    try {
      function(*database_);
    } catch (const std::exception& error) {
      log::error("store: {}: {}", what, error.what());
    }
  });
}

void Store::now(const std::function<void(Database&)>& function) {
  std::mutex mutex;
  std::condition_variable ended;
  bool over = false;
  std::exception_ptr error;
  thread_.post([&] {
    std::exception_ptr thrown;
    try {
      function(*database_);
    } catch (...) {
      thrown = std::current_exception();
    }
    // The last this thread does with anything of the caller's; what was thrown is the caller's alone from here on.
    const std::scoped_lock lock(mutex);
    error = std::move(thrown);
    over = true;
    ended.notify_one();
  });
  std::unique_lock lock(mutex);
  ended.wait(lock, [&] { return over; });
  if (error) std::rethrow_exception(error);
}

}  // namespace headstock::db
