#include "agent/machine_clock.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <chrono>
#include <cstring>

#include "protocol/process/log.hpp"

namespace headstock::agent {
namespace {

constexpr int kPriority = 80;

timespec after(timespec t, long ns) {
  t.tv_nsec += ns;
  while (t.tv_nsec >= 1'000'000'000) {
    t.tv_nsec -= 1'000'000'000;
    ++t.tv_sec;
  }
  return t;
}

std::int64_t ns_between(const timespec& from, const timespec& to) {
  return (to.tv_sec - from.tv_sec) * 1'000'000'000 + (to.tv_nsec - from.tv_nsec);
}

/// Says once, in words, how good the clock of this machine is: a degraded one must be visible.
bool ask_for_real_time() {
  sched_param param{};
  param.sched_priority = kPriority;
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  if (refused) {
    log::warning("real-time scheduling is not permitted ({}): periods may come late; they are counted and shown",
                 std::strerror(refused));
  }
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) log::warning("memory could not be locked: {}", std::strerror(errno));
  return refused == 0;
}

}  // namespace

MachineClock::MachineClock(operation::Controller& controller, Clock clock) : controller_(controller) {
  if (clock == Clock::fast) {
    periods_ = std::jthread([this](const std::stop_token& stop) { run_fast(stop); });
    return;
  }
  look_ahead_ = std::jthread([this](const std::stop_token& stop) { run_look_ahead(stop); });
  periods_ = std::jthread([this](const std::stop_token& stop) { run_real_time(stop); });
}

MachineClock::~MachineClock() {
  stop();
}

void MachineClock::stop() {
  periods_.request_stop();
  look_ahead_.request_stop();
  if (periods_.joinable()) periods_.join();
  if (look_ahead_.joinable()) look_ahead_.join();
}

void MachineClock::run_real_time(const std::stop_token& stop) {
  real_time_ = ask_for_real_time();
  const long period_ns = controller_.machine().period_us * 1000L;
  timespec due{};
  clock_gettime(CLOCK_MONOTONIC, &due);
  while (!stop.stop_requested()) {
    due = after(due, period_ns);
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    lateness_.add(ns_between(due, now));
    controller_.step();
    clock_gettime(CLOCK_MONOTONIC, &now);
    const std::int64_t late = ns_between(due, now) / period_ns;
    if (late > 0) {
      // Late periods are not made up for: the axes are late then, but never faster than their limits.
      controller_.count_overruns(static_cast<std::uint64_t>(late));
      due = now;
    }
  }
}

void MachineClock::run_look_ahead(const std::stop_token& stop) {
  using namespace std::chrono_literals;
  while (!stop.stop_requested()) {
    if (!controller_.work()) std::this_thread::sleep_for(500us);
  }
}

void MachineClock::run_fast(const std::stop_token& stop) {
  const auto period = std::chrono::microseconds(controller_.machine().period_us);
  while (!stop.stop_requested()) {
    while (controller_.work() && !stop.stop_requested()) {
    }
    controller_.step();
    // Waiting is done at the ordinary pace: a dwell, an operator, data that have not come yet.
    if (!controller_.sample().moving) std::this_thread::sleep_for(period);
  }
}

}  // namespace headstock::agent
