// Throughput of a drip-feed over loopback, from a stored program to the interpreter's thread, hashed, checked
// and resumable; and, in turn with it, of `openssl s_server` and `s_client` as the reference. Prints one JSON
// line: the medians of the rounds, and the medians of the rounds' ratios, of speed and of processor time.
// Exit status 1 when the bytes were not identical.
//
//   bench_drip [MiB, default 256] [rounds, default 5]
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "protocol/process/log.hpp"
#include "tests/bench/openssl_pair.hpp"
#include "tests/bench/repeated_text.hpp"
#include "tests/unit/link/shop.hpp"

namespace {

using namespace headstock;
using namespace headstock::testing_support;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// Processor time of this process and of the programs it has waited for: unlike MB/s it hardly depends on
/// what else the computer does.
double cpu_seconds() {
  double seconds = 0;
  for (const auto whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    struct rusage usage {};
    ::getrusage(whose, &usage);
    for (const timeval& part : {usage.ru_utime, usage.ru_stime})
      seconds += static_cast<double>(part.tv_sec) + static_cast<double>(part.tv_usec) * 1e-6;
  }
  return seconds;
}

double drip(std::uint64_t bytes, bool& identical) {
  Shop shop;
  asio::io_context agent_io;
  Agent agent(shop.folder.path() / "agent");
  auto options = agent.options(shop.gateway->port());
  options.enrolment_token = shop.token_for(1);
  agent.connect(agent_io, options);
  const auto work = asio::make_work_guard(agent_io);
  std::thread agent_thread([&] { agent_io.run(); });
  shop.until([&] { return shop.gateway->is_connected(1); });

  const auto blob = std::make_shared<bench::RepeatedText>(program_text(1 << 20), bytes);
  const std::string sha256 = blob->sha256();
  const auto start = Clock::now();
  const auto answer = shop.wait_for(shop.gateway->drip(1, 1, "big.nc", sha256, blob));
  std::atomic<bool> ended = false;
  std::uint64_t received = 0;
  auto status = program::ReadStatus::wait;
  std::thread interpreter([&] {
    std::string buffer(64 << 10, '\0');
    while (answer.accepted) {
      const auto result = agent.machine.stream->read({buffer.data(), buffer.size()});
      status = result.status;
      received += result.bytes;
      if (status == program::ReadStatus::wait)
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      else if (status != program::ReadStatus::data)
        break;
    }
    ended = true;
  });
  while (!ended) shop.run_for(std::chrono::milliseconds(2));
  const double seconds = seconds_since(start);
  interpreter.join();
  identical = received == bytes &&
              status == program::ReadStatus::end;  // `end` comes only after the hash of all was proven
  agent_io.stop();
  agent_thread.join();
  agent.link.reset();
  return static_cast<double>(bytes) / 1e6 / seconds;
}

}  // namespace

int main(int count, char** arguments) {
  headstock::log::leave_out_below("off");
  ::signal(SIGPIPE, SIG_IGN);
  const std::uint64_t bytes = (count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 256) << 20;
  const int rounds = count > 2 ? std::max(1, std::atoi(arguments[2])) : 5;
  const TemporaryFolder folder;
  std::vector<double> references, fed, ratios, cpu_ratios;
  bool identical = true;
  for (int round = 0; round < rounds; ++round) {
    const double before = cpu_seconds();
    references.push_back(bench::openssl_pair_mb_s(folder.path(), bytes));
    const double between = cpu_seconds();
    bool same = false;
    fed.push_back(drip(bytes, same));
    identical = identical && same;
    ratios.push_back(references.back() > 0 ? fed.back() / references.back() : 0);
    cpu_ratios.push_back((cpu_seconds() - between) / std::max(between - before, 1e-3));
  }
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "{\"drip_mb_s\":%.1f,\"openssl_pair_mb_s\":%.1f,\"ratio\":%.3f,\"cpu_of_openssl\":%.2f,\"rounds\":%d,"
      "\"mib\":%llu,"
      "\"identical\":%s,"
      "\"peak_memory_mib\":%ld}\n",
      median(fed), median(references), median(ratios), median(cpu_ratios), rounds,
      static_cast<unsigned long long>(bytes >> 20), identical ? "true" : "false", usage.ru_maxrss / 1024);
  return identical ? 0 : 1;
}
