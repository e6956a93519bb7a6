// What is noted of a run while it goes on, for its record: holds, alarms, the overrides it was run with.
#pragma once

#include <algorithm>
#include <cstdint>

namespace headstock::operation {

struct RunRecord {
  std::uint32_t holds = 0;   ///< feed holds, by a person or because data ran out
  std::uint32_t alarms = 0;  ///< without operator messages
  /// Overrides as factors, 1 = 100 %: the least and the most of each while it ran.
  double feed_least = 1, feed_most = 1, rapid_least = 1, rapid_most = 1, spindle_least = 1, spindle_most = 1;

  /// The overrides with which a run begins.
  static RunRecord begin(double feed, double rapid, double spindle) {
    RunRecord record;
    record.feed_least = record.feed_most = feed;
    record.rapid_least = record.rapid_most = rapid;
    record.spindle_least = record.spindle_most = spindle;
    return record;
  }
  void overrides(double feed, double rapid, double spindle) {
    feed_least = std::min(feed_least, feed);
    feed_most = std::max(feed_most, feed);
    rapid_least = std::min(rapid_least, rapid);
    rapid_most = std::max(rapid_most, rapid);
    spindle_least = std::min(spindle_least, spindle);
    spindle_most = std::max(spindle_most, spindle);
  }
};

}  // namespace headstock::operation
