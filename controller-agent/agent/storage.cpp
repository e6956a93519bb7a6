#include "agent/storage.hpp"

#include <chrono>
#include <vector>

#include "agent/retained.hpp"
#include "link/live_json.hpp"
#include "protocol/process/log.hpp"

namespace headstock::agent {
namespace {

using namespace std::chrono_literals;
constexpr auto kRetry = 500ms;
// While a program runs its block is written so often: what a power loss costs at most in blocks cut again.
constexpr auto kBreakpointEvery = 2s;

bool same_settings(const operation::Retained& a, const operation::Retained& b) {
  return a.parts == b.parts && a.parts_required == b.parts_required && a.feed_override == b.feed_override &&
         a.rapid_override == b.rapid_override && a.spindle_override == b.spindle_override &&
         a.breakpoint == b.breakpoint;
}

}  // namespace

Storage::Storage(operation::Controller& controller, link::Spool& spool)
    : controller_(controller), spool_(spool), kept_(controller.retained()) {
  controller_.on_event([this] {
    const std::scoped_lock lock(mutex_);
    something_ = true;
    woken_.notify_one();
  });
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

Storage::~Storage() {
  controller_.on_event({});
  thread_.request_stop();
  thread_.join();
}

void Storage::run(const std::stop_token& stop) {
  while (true) {
    // After the stop was asked for, one last look: nothing that happened before it is left behind.
    const bool last_look = stop.stop_requested();
    while (commit_some()) {
    }
    if (last_look) return;
    std::unique_lock lock(mutex_);
    (void)woken_.wait_for(lock, stop, kBreakpointEvery, [this] { return something_; });
    something_ = false;
  }
}

bool Storage::commit_some() {
  const operation::Taken taken = controller_.take_events();
  const operation::Retained& now = taken.retained;
  if (taken.events.empty() && same_settings(now, kept_)) return false;
  std::vector<link::NewEvent> events;
  for (const operation::TimedEvent& event : taken.events) events.push_back(link::to_new_event(event));
  std::vector<link::RetainedValue> retained{counters_value(now)};
  if (taken.data) retained.push_back(data_value(*taken.data, controller_.machine()));
  while (true) {
    try {
      spool_.commit(events, retained);
      break;
    } catch (const link::SpoolError& error) {
      // The controller waits at the end of its cycle until this has worked: a part is late, never lost.
      log::error("cannot store on this machine's disk, trying again: {}", error.what());
      std::this_thread::sleep_for(kRetry);
      if (thread_.get_stop_token().stop_requested()) return false;
    }
  }
  kept_ = now;
  committed_ += events.size();
  controller_.committed(committed_);
  return !events.empty();
}

}  // namespace headstock::agent
