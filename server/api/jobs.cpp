#include "server/api/jobs.hpp"

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "db/database.hpp"
#include "db/refusal.hpp"

namespace headstock::api {

namespace asio = boost::asio;
using Clock = std::chrono::steady_clock;

struct Jobs::Job {
  explicit Job(asio::io_context& io) : finished(io) {}
  std::int64_t owner = 0;
  bool done = false;
  nlohmann::json result;
  std::exception_ptr error;
  asio::steady_timer finished;
  Clock::time_point at{};
};

namespace {

nlohmann::json error_of(const std::exception_ptr& error) {
  Refused refused("internal");
  try {
    std::rethrow_exception(error);
  } catch (const Refused& known) {
    refused = known;
  } catch (const db::Refusal& known) {
    refused = Refused(known.code(), known.where());
  } catch (const std::exception&) {
  }
  return nlohmann::json::parse(error_reply(refused).body).at("error");
}

}  // namespace

void Jobs::forget_old() {
  const auto old = Clock::now() - std::chrono::minutes(10);
  for (auto it = jobs_.begin(); it != jobs_.end();) {
    const bool full = jobs_.size() >= kept_;
    if (it->second->done && (full || it->second->at < old))
      it = jobs_.erase(it);
    else
      ++it;
  }
}

asio::awaitable<Reply> Jobs::run(asio::awaitable<nlohmann::json> work, std::int64_t owner,
                                 std::chrono::milliseconds patience) {
  forget_old();
  if (jobs_.size() >= kept_) throw Refused("busy");
  const auto job = std::make_shared<Job>(io_);
  const auto id = ++last_id_;
  job->owner = owner;
  job->finished.expires_after(patience);
  jobs_[id] = job;
  asio::co_spawn(io_, std::move(work), [job](std::exception_ptr error, nlohmann::json result) {
    job->done = true;
    job->error = error;
    job->result = std::move(result);
    job->at = Clock::now();
    job->finished.cancel();
  });
  co_await job->finished.async_wait(asio::as_tuple(asio::use_awaitable));
  if (!job->done) co_return json_reply({{"job", id}, {"state", "running"}}, 202);
  jobs_.erase(id);
  if (job->error) std::rethrow_exception(job->error);
  co_return json_reply(job->result);
}

nlohmann::json Jobs::find(std::int64_t id, std::int64_t owner) {
  const auto found = jobs_.find(id);
  if (found == jobs_.end() || found->second->owner != owner) throw Refused("not_found", "job");
  const Job& job = *found->second;
  nlohmann::json json = {{"job", id}, {"state", "running"}, {"result", nullptr}, {"error", nullptr}};
  if (!job.done) return json;
  json["state"] = job.error ? "failed" : "done";
  if (job.error)
    json["error"] = error_of(job.error);
  else
    json["result"] = job.result;
  return json;
}

}  // namespace headstock::api
