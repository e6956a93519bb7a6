// Drip-feeds to a hall of machines at once: real TLS links, each machine executing so many blocks a second. A
// machine is starved when a block was due and its buffer was empty. Prints one JSON line; exit status 1 when
// one was starved or did not get exactly its program.
//
//   bench_drip_fleet [agents, default 200] [blocks a second, default 10000] [seconds, default 20]
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#include "protocol/process/log.hpp"
#include "tests/bench/repeated_text.hpp"
#include "tests/unit/link/shop.hpp"

namespace {

using namespace headstock;
using namespace headstock::testing_support;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

double cpu_seconds() {
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6;
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// One machine as its interpreter sees it.
struct Demand {
  program::Source* source = nullptr;
  std::uint64_t blocks = 0, bytes = 0, starved = 0;
  bool over = false, failed = false;
  wire::Sha256 digest;

  /// Takes blocks until `due` of them have been executed.
  void take(std::uint64_t due) {
    char buffer[4096];
    while (!over && blocks < due) {
      // No more than is due, about: a machine does not run ahead of its axes.
      const auto wanted =
          static_cast<std::size_t>(std::min<std::uint64_t>(sizeof buffer, (due - blocks) * 24 + 1));
      const auto result = source->read({buffer, wanted});
      if (result.status == program::ReadStatus::data) {
        bytes += result.bytes;
        digest.update({buffer, result.bytes});
        blocks += static_cast<std::uint64_t>(std::count(buffer, buffer + result.bytes, '\n'));
        continue;
      }
      over = result.status == program::ReadStatus::end;
      failed = result.status == program::ReadStatus::failed;
      if (failed) over = true;
      if (!over) ++starved;
      return;
    }
  }
};

}  // namespace

int main(int count, char** arguments) {
  headstock::log::leave_out_below("off");
  const int agents_wanted = count > 1 ? std::atoi(arguments[1]) : 200;
  const double rate = count > 2 ? std::atof(arguments[2]) : 10'000;
  const double seconds = count > 3 ? std::atof(arguments[3]) : 20;

  Shop shop;
  asio::io_context agent_io;
  std::vector<std::unique_ptr<Agent>> agents;
  for (int i = 1; i <= agents_wanted; ++i) {
    agents.push_back(std::make_unique<Agent>(shop.folder.path() / std::to_string(i)));
    auto options = agents.back()->options(shop.gateway->port());
    options.enrolment_token = shop.token_for(i);
    options.reconnect_max = milliseconds(500);
    agents.back()->connect(agent_io, options);
  }
  const auto work = asio::make_work_guard(agent_io);
  std::thread agent_thread([&] { agent_io.run(); });
  for (int i = 1; i <= agents_wanted; ++i)
    if (!shop.until([&] { return shop.gateway->is_connected(i); }))
      return std::fprintf(stderr, "agent %d does not come\n", i), 1;

  const std::string piece = program_text(1 << 20);
  const double bytes_a_block =
      static_cast<double>(piece.size()) / static_cast<double>(std::count(piece.begin(), piece.end(), '\n'));
  bench::RepeatedText whole(piece, static_cast<std::uint64_t>(rate * seconds * bytes_a_block));
  const std::string sha256 = whole.sha256();
  std::vector<Demand> demands(agents.size());
  for (std::size_t i = 0; i < agents.size(); ++i) {
    const auto machine = static_cast<std::int64_t>(i + 1);
    const auto answer = shop.wait_for(shop.gateway->drip(
        i + 1, machine, "big.nc", sha256, std::make_shared<bench::RepeatedText>(piece, whole.size())));
    if (!answer.accepted) return std::fprintf(stderr, "machine %zu: %s\n", i + 1, answer.reason.c_str()), 1;
    demands[i].source = agents[i]->machine.stream.get();
  }
  // The operator starts when the buffer is full, not before.
  shop.run_for(milliseconds(500));

  const double cpu_before = cpu_seconds();
  const auto start = Clock::now();
  std::atomic<bool> done = false;
  std::thread machines([&] {
    auto next = start;
    while (!std::ranges::all_of(demands, &Demand::over)) {
      const double elapsed = std::chrono::duration<double>(Clock::now() - start).count();
      for (Demand& demand : demands) demand.take(static_cast<std::uint64_t>(elapsed * rate) + 1);
      next += milliseconds(10);
      std::this_thread::sleep_until(next);
    }
    done = true;
  });
  while (!done) shop.run_for(milliseconds(5));
  machines.join();
  const double took = std::chrono::duration<double>(Clock::now() - start).count();
  const double cpu = cpu_seconds() - cpu_before;

  std::uint64_t starved = 0, starved_machines = 0, blocks = 0, least = ~std::uint64_t{0};
  bool identical = true;
  for (Demand& demand : demands) {
    starved += demand.starved;
    starved_machines += demand.starved > 0;
    blocks += demand.blocks;
    least = std::min(least, demand.blocks);
    identical = identical && !demand.failed && demand.bytes == whole.size() && demand.digest.hex() == sha256;
  }
  agent_io.stop();
  agent_thread.join();
  for (auto& agent : agents) agent->link.reset();
  std::printf(
      "{\"agents\":%d,\"asked_blocks_s\":%.0f,\"least_blocks_s\":%.0f,\"all_blocks_s\":%.0f,\"mb_s\":%.1f,"
      "\"starved_machines\":%llu,\"starved_times\":%llu,\"identical\":%s,\"seconds\":%.1f,"
      "\"cpu_percent_of_one_core\":%.0f}\n",
      agents_wanted, rate, static_cast<double>(least) / took, static_cast<double>(blocks) / took,
      static_cast<double>(whole.size()) * agents_wanted / 1e6 / took,
      static_cast<unsigned long long>(starved_machines), static_cast<unsigned long long>(starved),
      identical ? "true" : "false", took, 100 * cpu / took);
  return identical && starved == 0 ? 0 : 1;
}
