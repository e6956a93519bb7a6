// Rules that tell somebody of alarms, the events they made, and the messages that are on their way. Plain rows; what
// follows from what is in server/integrations. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "db/event_store.hpp"
#include "db/page.hpp"

namespace headstock::db {

struct AlarmRuleRow {
  std::int64_t id = 0;
  std::string name;
  std::int64_t machine = 0, group = 0;  ///< both 0: every machine
  std::string code;                     ///< with `*` for anything; empty: every code
  std::int64_t after_s = 0;             ///< only alarms that stay at least so long
  std::string email, webhook;           ///< addresses with commas between; empty: none
  std::int64_t escalate_after_s = 0;    ///< without an acknowledgement; 0: never
  std::string escalate_email, escalate_webhook;
  std::int64_t again_after_s = 300;     ///< an alarm that comes back earlier than this is the same event
  bool enabled = true;
  std::int64_t since_alarm = 0;         ///< alarms up to this id are dealt with
};
std::vector<AlarmRuleRow> alarm_rules(Database& db);
/// id 0: a new one, from the newest alarm on. @return its id.
std::int64_t put_alarm_rule(Database& db, const AlarmRuleRow& rule);
void set_since_alarm(Database& db, std::int64_t rule, std::int64_t alarm);
/// Its events stay. @return false when there is none.
bool remove_alarm_rule(Database& db, std::int64_t id, std::int64_t at_ms);
/// Not yet dealt with, oldest first, at most 1,000.
std::vector<AlarmRow> alarms_after(Database& db, std::int64_t alarm);

struct AlarmEventRow {
  std::int64_t id = 0, rule = 0, machine = 0;
  std::string rule_name, machine_name;  ///< read only
  std::string code;
  std::int64_t alarm = 0;               ///< the newest alarm of it
  std::string text_en, text_zh;         ///< read only, of that alarm
  std::int64_t first_ms = 0, last_ms = 0, times = 1;
  std::optional<std::int64_t> cleared_ms, acknowledged_ms, escalated_ms;
  std::string acknowledged_by, acknowledged_note;
};
std::optional<AlarmEventRow> newest_alarm_event(Database& db, std::int64_t rule, std::int64_t machine, const std::string& code);
std::optional<AlarmEventRow> alarm_event(Database& db, std::int64_t id);
struct AlarmEventFilter {
  bool open_only = false;  ///< neither cleared nor acknowledged
  std::int64_t machine = 0;
};
Listed<AlarmEventRow> alarm_events(Database& db, const AlarmEventFilter& filter, const Page& page);
std::int64_t insert_alarm_event(Database& db, const AlarmEventRow& event);
/// The same alarm again: once more, open again.
void repeat_alarm_event(Database& db, std::int64_t id, std::int64_t alarm, std::int64_t at_ms);
/// Ends the events whose newest alarm has been cleared.
void clear_alarm_events(Database& db);
bool acknowledge_alarm_event(Database& db, std::int64_t id, const std::string& by, const std::string& note, std::int64_t at_ms);
/// Open, not acknowledged, not escalated, older than their rule allows.
std::vector<AlarmEventRow> alarm_events_to_escalate(Database& db, std::int64_t now_ms);
void mark_escalated(Database& db, std::int64_t id, std::int64_t at_ms);

struct NoticeRow {
  std::int64_t id = 0, event = 0;
  std::string kind;    ///< email webhook
  std::string step;    ///< first escalation cleared test
  std::string target;
  std::string body;    ///< JSON, as a webhook gets it
  std::string state = "waiting";  ///< waiting sent failed
  std::int64_t attempts = 0, next_ms = 0;
  std::optional<std::int64_t> sent_ms;
  std::string problem;
};
std::int64_t insert_notice(Database& db, const NoticeRow& notice);
std::vector<NoticeRow> notices_due(Database& db, std::int64_t now_ms, int at_most);
std::vector<NoticeRow> notices_of(Database& db, std::int64_t event);
void update_notice(Database& db, const NoticeRow& notice);
/// First notices of the rule's events since then.
std::int64_t notices_since(Database& db, std::int64_t rule, std::int64_t from_ms);

}  // namespace headstock::db
