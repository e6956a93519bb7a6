// Why machines stood, and which parts were no good: entered by people, never changed, corrected by a newer
// entry. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "server/access/role.hpp"
#include "server/fleet/shifts.hpp"

namespace headstock::fleet {

struct DowntimeReason {
  std::int64_t id = 0;
  std::string name_en, name_zh;
  bool planned = false;  ///< breaks, maintenance, no order: not the machine's loss
};

struct DowntimeNote : Span {
  std::int64_t id = 0, machine = 0;
  std::optional<std::int64_t> reason;  ///< nothing: an earlier entry is taken back
  bool planned = false;                ///< of the reason
  std::string note, by_user;
  std::int64_t at_ms = 0;
};

struct Reject {
  std::int64_t id = 0, machine = 0, at_ms = 0;
  std::string program;
  std::int64_t quantity = 0;  ///< negative: an earlier entry is taken back
  std::string why, by_user;
  std::int64_t entered_ms = 0;
};

/// A stretch of time in which the machine did not run.
struct Stop : Span {
  std::string state;                 ///< what it was in for most of it
  bool open = false;                 ///< still standing
  std::optional<DowntimeNote> note;  ///< the newest that covers its beginning
};

std::vector<DowntimeReason> downtime_reasons(db::Database& db);
/// New when id is 0. Names in both languages are needed.
DowntimeReason put_downtime_reason(db::Database& db, const access::Actor& actor,
                                   const DowntimeReason& reason);
/// What was entered with it keeps it.
void remove_downtime_reason(db::Database& db, const access::Actor& actor, std::int64_t id,
                            std::int64_t now_ms);

/// Enters why the machine stood. Refuses times that are no span, lie in the future or reach over 31 days.
DowntimeNote note_downtime(db::Database& db, const access::Actor& actor, const DowntimeNote& note,
                           std::int64_t now_ms);
/// All that touch the time, oldest entry first.
std::vector<DowntimeNote> downtime_notes(db::Database& db, std::int64_t machine, const Span& within);
/// The notes without overlap: where two cover one instant the newer entry counts. By time.
std::vector<DowntimeNote> settled(std::vector<DowntimeNote> notes);

/// Stretches without running, at least `shortest_ms` long, oldest first. Silence (`unknown`, `off`) is a stop
/// of its own, never joined with what was seen.
std::vector<Stop> stops(db::Database& db, std::int64_t machine, const Span& within, std::int64_t shortest_ms,
                        std::int64_t now_ms);

Reject note_reject(db::Database& db, const access::Actor& actor, const Reject& reject, std::int64_t now_ms);
std::vector<Reject> rejects(db::Database& db, std::int64_t machine, const Span& within);

}  // namespace headstock::fleet
