// When events happened, as far as the machine's clock can be believed: nothing happens after it was heard of,
// and nothing before what the machine's own numbering puts first. A clock that breaks this by more than a
// minute (set wrong, set back, a dead battery) is an alarm with its name; the events are kept with the
// nearest time that can be, and with the time that was told in their raw body. A clock that is behind by the
// same amount all the time cannot be told from a late delivery. Store thread, inside the transaction of the
// intake.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "db/event_store.hpp"

namespace headstock::fleet {

inline constexpr const char* kClockAlarm = "HS-CLOCK";
inline constexpr std::int64_t kClockSlackMs = 60'000;

class EventTimes {
 public:
  EventTimes(db::Database& db, std::int64_t machine, std::string spool, std::int64_t now_ms)
      : db_(db), machine_(machine), spool_(std::move(spool)), now_ms_(now_ms) {}

  /// Ask in the order of the sequences.
  std::int64_t of(std::int64_t sequence, std::int64_t told_ms);
  /// After the batch: raises the alarm, or ends it when the clock went well through a whole batch.
  void tell(std::vector<db::AlarmRow>& raised, std::vector<db::AlarmRow>& cleared);

 private:
  db::Database& db_;
  std::int64_t machine_;
  std::string spool_;
  std::int64_t now_ms_;
  std::int64_t before_ms_ = -1;   ///< of the event before; -1: not looked up yet
  std::int64_t last_ = 0;         ///< sequence asked for last
  std::int64_t wrong_by_ms_ = 0;  ///< the largest: ahead > 0, back < 0
  std::int64_t wrong_at_ = 0;     ///< its sequence
};

}  // namespace headstock::fleet
