#include "server/backup/retention.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/access_store.hpp"
#include "db/backup_store.hpp"
#include "db/event_store.hpp"
#include "db/refusal.hpp"
#include "db/time.hpp"
#include "server/access/audit.hpp"
#include "server/backup/archive.hpp"

namespace headstock::backup {
namespace {

using nlohmann::json;

constexpr int kEventsAtOnce = 5'000;  // nothing else is written meanwhile

struct Setting {
  const char* name;
  std::int64_t RetentionSettings::*value;
  std::int64_t low, high;
};
constexpr Setting kSettings[] = {
    {"events_days", &RetentionSettings::events_days, 7, 36'500},
    {"states_days", &RetentionSettings::states_days, 7, 36'500},
    {"transfers_days", &RetentionSettings::transfers_days, 7, 36'500},
    {"backup_every_hours", &RetentionSettings::backup_every_hours, 1, 744},
    {"backups_kept", &RetentionSettings::backups_kept, 1, 1'000},
};

std::string key_of(const Setting& setting) {
  return std::string("keeping.") + setting.name;
}

/// A piece of one hour.
struct Piece {
  std::string state, mode, source;
  std::int64_t ms = 0;
};

/// The hour's pieces with one for each state and source, in the order of their first; the longest gives the mode.
std::vector<Piece> gathered(const std::vector<Piece>& pieces) {
  std::vector<Piece> found;
  std::map<std::pair<std::string, std::string>, std::int64_t> longest;
  for (const Piece& piece : pieces) {
    auto one = std::ranges::find_if(found, [&](const Piece& p) { return p.state == piece.state && p.source == piece.source; });
    if (one == found.end()) one = found.insert(found.end(), {piece.state, piece.mode, piece.source, 0});
    one->ms += piece.ms;
    auto& most = longest[{piece.state, piece.source}];
    if (piece.ms > most) {
      most = piece.ms;
      one->mode = piece.mode;
    }
  }
  return found;
}

}  // namespace

RetentionSettings retention_settings(db::Database& db) {
  RetentionSettings settings;
  for (const Setting& setting : kSettings)
    if (const auto text = db::setting(db, key_of(setting))) {
      std::int64_t value = 0;
      if (std::from_chars(text->data(), text->data() + text->size(), value).ec == std::errc()) settings.*setting.value = value;
    }
  return settings;
}

void set_retention(db::Database& db, const access::Actor& actor, const RetentionSettings& settings) {
  access::demand(actor, access::Action::manage_backups);
  for (const Setting& setting : kSettings) {
    const std::int64_t value = settings.*setting.value;
    const bool off = value == 0 && setting.value != &RetentionSettings::backups_kept;
    if (!off && (value < setting.low || value > setting.high)) throw db::Refusal("bad_value", setting.name);
  }
  db::Transaction transaction(db);
  std::string all;
  for (const Setting& setting : kSettings) {
    db::put_setting(db, key_of(setting), std::to_string(settings.*setting.value));
    all += (all.empty() ? "" : " ") + std::string(setting.name) + "=" + std::to_string(settings.*setting.value);
  }
  access::record(db, actor, "settings.keeping", "settings", {{"values", all}});
  transaction.commit();
}

std::optional<std::int64_t> coarsen_states(db::Database& db, std::int64_t machine, std::int64_t before_ms) {
  const std::string key = "keeping.states_until." + std::to_string(machine);
  const std::int64_t end = before_ms / db::kHourMs * db::kHourMs;
  db::Transaction transaction(db);
  // From where the last time ended, or the first whole hour of the record.
  std::int64_t begin = 0;
  if (const auto text = db::setting(db, key)) begin = std::stoll(*text);
  const auto first = db.integer("SELECT MIN(from_ms) FROM state_intervals WHERE machine_id = ? AND to_ms > ?", {machine, begin});
  if (!first) return std::nullopt;
  begin = std::max(begin, (*first + db::kHourMs - 1) / db::kHourMs * db::kHourMs);
  const std::int64_t stop = std::min(end, begin + db::kDayMs);
  if (begin >= stop) return std::nullopt;

  std::vector<db::StateRow> rows;
  db::HistoryFilter filter;
  filter.machine = machine;
  filter.from_ms = begin;
  filter.to_ms = stop;
  db::each_state(db, filter, [&](const db::StateRow& row) {
    if (row.to_ms.value_or(stop) > begin) rows.push_back(row);
  });
  if (rows.size() <= 1) {  // one state over the whole time: nothing to gather
    db::put_setting(db, key, std::to_string(stop));
    transaction.commit();
    return 0;
  }
  std::map<std::int64_t, std::vector<Piece>> hours;  // by the hour's start
  std::map<std::int64_t, std::int64_t> starts;       // where the record of the hour begins: it may have a hole
  for (const db::StateRow& row : rows) {
    std::int64_t at = std::max(row.from_ms, begin);
    const std::int64_t to = std::min(row.to_ms.value_or(stop), stop);
    while (at < to) {
      const std::int64_t hour = at / db::kHourMs * db::kHourMs, until = std::min(to, hour + db::kHourMs);
      hours[hour].push_back({row.state, row.mode, row.source, until - at});
      starts.try_emplace(hour, at);
      at = until;
    }
  }
  // What reaches over the edges keeps its part outside; the rest is made anew.
  std::vector<db::StateRow> made;
  const auto put = [&](const Piece& piece, std::int64_t from, std::int64_t to) {
    if (!made.empty() && made.back().to_ms == from && made.back().state == piece.state && made.back().source == piece.source)
      made.back().to_ms = to;
    else
      made.push_back({0, machine, piece.state, piece.mode, piece.source, from, to});
  };
  for (const auto& [hour, pieces] : hours) {
    std::int64_t at = starts.at(hour);
    for (const Piece& piece : gathered(pieces)) {
      put(piece, at, at + piece.ms);
      at += piece.ms;
    }
  }
  std::int64_t before = 0;
  for (const db::StateRow& row : rows) {
    const std::int64_t to = row.to_ms.value_or(0);
    const bool open = !row.to_ms;
    if (row.from_ms >= begin && !open && to <= stop) {
      db.execute("DELETE FROM state_intervals WHERE id = ?", {row.id});
      ++before;
    } else if (row.from_ms < begin) {
      db.execute("UPDATE state_intervals SET to_ms = ? WHERE id = ?", {begin, row.id});
    } else {
      db.execute("UPDATE state_intervals SET from_ms = ? WHERE id = ?", {stop, row.id});
    }
  }
  for (const db::StateRow& row : made)
    db.execute("INSERT INTO state_intervals (machine_id, state, mode, source, from_ms, to_ms) VALUES (?, ?, ?, ?, ?, ?)",
               {machine, row.state, row.mode, row.source, row.from_ms, row.to_ms});
  db::put_setting(db, key, std::to_string(stop));
  transaction.commit();
  return before - static_cast<std::int64_t>(made.size());
}

std::int64_t archive_events(db::Database& db, const std::filesystem::path& data_folder, std::int64_t before_ms,
                            std::int64_t now_ms) {
  namespace fs = std::filesystem;
  struct Key {
    std::int64_t machine;
    std::string spool;
    std::int64_t sequence;
  };
  std::vector<Key> keys;
  std::string text;
  db::EventArchiveRow row;
  // Parts refer to their events, and the counts can be computed again from them.
  db.each("SELECT machine_id, spool, sequence, at_ms, received_ms, kind, body FROM events WHERE received_ms < ? AND kind NOT "
          "IN ('part', 'run_started', 'run_ended') ORDER BY received_ms, machine_id, spool, sequence LIMIT " +
              std::to_string(kEventsAtOnce),
          {before_ms}, [&](const db::Row& event) {
            keys.push_back({event.integer(0), event.text(1), event.integer(2)});
            const std::int64_t at = event.integer(4);
            if (row.events++ == 0) row.from_ms = at;
            row.to_ms = at;
            text += json::array({event.integer(0), event.text(1), event.integer(2), event.integer(3), at, event.text(5), event.text(6)})
                        .dump(-1, ' ', false, json::error_handler_t::replace);
            text += '\n';
          });
  if (keys.empty()) return 0;
  fs::create_directories(data_folder / "archive");
  row.file = "events-" + std::to_string(row.from_ms) + "-" + std::to_string(now_ms) + ".tar.zst";
  const fs::path file = data_folder / "archive" / row.file;
  ArchiveWriter writer(file);
  writer.add("events.jsonl", text);
  row.sha256 = writer.finish({{"kind", "events"}, {"events", row.events}}).sha256;
  verify(file);  // what cannot be read back is not taken out
  row.at_ms = now_ms;
  db::Transaction transaction(db);
  db.set_guard("events", "events_kept_delete", db::Guard::open);
  for (const Key& key : keys)
    db.execute("DELETE FROM events WHERE machine_id = ? AND spool = ? AND sequence = ?", {key.machine, key.spool, key.sequence});
  db.set_guard("events", "events_kept_delete", db::Guard::closed);
  db::insert_event_archive(db, row);
  access::record(db, access::Actor{}, "events.archive", "events", {{"file", row.file}, {"sha256", row.sha256}, {"events", std::to_string(row.events)}});
  transaction.commit();
  return row.events;
}

std::int64_t forget_transfers(db::Database& db, std::int64_t before_ms) {
  db::Transaction transaction(db);
  std::int64_t count = db.execute("DELETE FROM transfers WHERE ended_ms IS NOT NULL AND ended_ms < ?", {before_ms});
  count += db.execute("DELETE FROM distributions WHERE at_ms < ? AND NOT EXISTS (SELECT 1 FROM transfers t WHERE "
                      "t.distribution_id = distributions.id)",
                      {before_ms});
  transaction.commit();
  return count;
}

}  // namespace headstock::backup
