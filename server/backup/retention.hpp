// What need not stay as fine as it was recorded. Part counts, runs, alarms, changes, revisions and the audit trail stay
// for ever; so do the events that part counts rest on. Old events of other kinds go into a compressed file beside the
// database, verified before they are taken out; old states are kept by the hour.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "db/database.hpp"
#include "server/access/role.hpp"

namespace headstock::backup {

/// Days; 0: for ever, as recorded.
struct RetentionSettings {
  std::int64_t events_days = 0;      ///< events that no part count rests on
  std::int64_t states_days = 0;      ///< intervals as recorded; older ones by the hour
  std::int64_t transfers_days = 0;   ///< records of transfers that are over
  std::int64_t backup_every_hours = 24;  ///< 0: only by hand
  std::int64_t backups_kept = 7;         ///< of the server's own; those made by hand stay
};
RetentionSettings retention_settings(db::Database& db);
/// Refusals: forbidden, bad_value (where: the setting; less than 7 days, more than 100 years).
void set_retention(db::Database& db, const access::Actor& actor, const RetentionSettings& settings);

/// One machine's states that ended before `before_ms`: in each full hour (UTC) one interval a state, in the order in
/// which the states first came, so that every hour's seconds of every state stay exactly what they were.
/// One transaction; at most a day's worth at a time. @return how many rows there are less; nothing: nothing was left to do.
std::optional<std::int64_t> coarsen_states(db::Database& db, std::int64_t machine, std::int64_t before_ms);

/// Events received before `before_ms` that no part rests on, at most 20,000 at a time: written to
/// DATA/archive/events-N.jsonl.zst, read back and compared, then taken out in one transaction.
/// @return how many; 0: nothing was left to do.
std::int64_t archive_events(db::Database& db, const std::filesystem::path& data_folder, std::int64_t before_ms,
                            std::int64_t now_ms);

/// Transfers over before `before_ms` and the plans that are empty without them. @return how many rows.
std::int64_t forget_transfers(db::Database& db, std::int64_t before_ms);

}  // namespace headstock::backup
