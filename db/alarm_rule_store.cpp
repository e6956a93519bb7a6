#include "db/alarm_rule_store.hpp"

#include "db/filter.hpp"

namespace headstock::db {
namespace {

/// No retry is so far away: the clock was set back, and nothing may wait for it to come round again.
constexpr std::int64_t kFarMs = 24 * 3'600'000;

Value id_or_null(std::int64_t id) {
  return id != 0 ? Value(id) : Value();
}

constexpr const char* kEvent =
    "SELECT e.id, e.rule_id, e.machine_id, r.name, m.name, e.code, e.alarm_id, COALESCE(a.text_en, ''), "
    "COALESCE(a.text_zh, ''), e.first_ms, e.last_ms, e.times, e.cleared_ms, e.acknowledged_ms, e.escalated_ms, "
    "e.acknowledged_by, e.acknowledged_note FROM alarm_events e JOIN alarm_rules r ON r.id = e.rule_id JOIN machines m "
    "ON m.id = e.machine_id LEFT JOIN alarms a ON a.id = e.alarm_id";

AlarmEventRow event_of(const Row& row) {
  AlarmEventRow event;
  event.id = row.integer(0);
  event.rule = row.integer(1);
  event.machine = row.integer(2);
  event.rule_name = row.text(3);
  event.machine_name = row.text(4);
  event.code = row.text(5);
  event.alarm = row.integer(6);
  event.text_en = row.text(7);
  event.text_zh = row.text(8);
  event.first_ms = row.integer(9);
  event.last_ms = row.integer(10);
  event.times = row.integer(11);
  event.cleared_ms = row.maybe_integer(12);
  event.acknowledged_ms = row.maybe_integer(13);
  event.escalated_ms = row.maybe_integer(14);
  event.acknowledged_by = row.text(15);
  event.acknowledged_note = row.text(16);
  return event;
}

std::vector<AlarmEventRow> events_where(Database& db, const std::string& where, const Values& values) {
  std::vector<AlarmEventRow> found;
  db.each(kEvent + where, values, [&](const Row& row) { found.push_back(event_of(row)); });
  return found;
}

constexpr const char* kNotice =
    "SELECT id, event_id, kind, step, target, body, state, attempts, next_ms, sent_ms, problem FROM notices ";

NoticeRow notice_of(const Row& row) {
  return {row.integer(0), row.integer(1), row.text(2),    row.text(3),          row.text(4), row.text(5),
          row.text(6),    row.integer(7), row.integer(8), row.maybe_integer(9), row.text(10)};
}

std::vector<NoticeRow> notices_where(Database& db, const std::string& where, const Values& values) {
  std::vector<NoticeRow> found;
  db.each(kNotice + where, values, [&](const Row& row) { found.push_back(notice_of(row)); });
  return found;
}

}  // namespace

std::vector<AlarmRuleRow> alarm_rules(Database& db) {
  std::vector<AlarmRuleRow> found;
  db.each("SELECT id, name, machine_id, group_id, code, after_s, email, webhook, escalate_after_s, escalate_email, "
          "escalate_webhook, again_after_s, enabled, since_alarm FROM alarm_rules WHERE removed_ms IS NULL ORDER BY id",
          {}, [&](const Row& row) {
            found.push_back({row.integer(0), row.text(1), row.integer(2), row.integer(3), row.text(4), row.integer(5),
                             row.text(6), row.text(7), row.integer(8), row.text(9), row.text(10), row.integer(11),
                             row.flag(12), row.integer(13)});
          });
  return found;
}

std::int64_t put_alarm_rule(Database& db, const AlarmRuleRow& rule) {
  Values values = {rule.name,  id_or_null(rule.machine), id_or_null(rule.group), rule.code,
                   rule.after_s, rule.email, rule.webhook, rule.escalate_after_s,
                   rule.escalate_email, rule.escalate_webhook, rule.again_after_s, rule.enabled};
  if (rule.id != 0) {
    values.emplace_back(rule.id);
    db.execute("UPDATE alarm_rules SET name = ?, machine_id = ?, group_id = ?, code = ?, after_s = ?, email = ?, "
               "webhook = ?, escalate_after_s = ?, escalate_email = ?, escalate_webhook = ?, again_after_s = ?, "
               "enabled = ? WHERE id = ?",
               values);
    return rule.id;
  }
  return *db.integer(
      "INSERT INTO alarm_rules (name, machine_id, group_id, code, after_s, email, webhook, escalate_after_s, "
      "escalate_email, escalate_webhook, again_after_s, enabled, since_alarm) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, "
      "(SELECT COALESCE(MAX(id), 0) FROM alarms)) RETURNING id",
      values);
}

void set_since_alarm(Database& db, std::int64_t rule, std::int64_t alarm) {
  db.execute("UPDATE alarm_rules SET since_alarm = ? WHERE id = ?", {alarm, rule});
}

bool remove_alarm_rule(Database& db, std::int64_t id, std::int64_t at_ms) {
  return db.execute("UPDATE alarm_rules SET removed_ms = ? WHERE id = ? AND removed_ms IS NULL", {at_ms, id}) > 0;
}

std::vector<AlarmRow> alarms_after(Database& db, std::int64_t alarm) {
  std::vector<AlarmRow> found;
  db.each("SELECT id, machine_id, code, text_en, text_zh, line, program, block, raised_ms, cleared_ms FROM alarms "
          "WHERE id > ? ORDER BY id LIMIT 1000",
          {alarm}, [&](const Row& row) {
            AlarmRow found_one;
            found_one.id = row.integer(0);
            found_one.machine = row.integer(1);
            found_one.code = row.text(2);
            found_one.text_en = row.text(3);
            found_one.text_zh = row.text(4);
            found_one.line = row.integer(5);
            found_one.program = row.text(6);
            found_one.block = row.text(7);
            found_one.raised_ms = row.integer(8);
            found_one.cleared_ms = row.maybe_integer(9);
            found.push_back(std::move(found_one));
          });
  return found;
}

std::optional<AlarmEventRow> newest_alarm_event(Database& db, std::int64_t rule, std::int64_t machine,
                                                const std::string& code) {
  auto found = events_where(db, " WHERE e.rule_id = ? AND e.machine_id = ? AND e.code = ? ORDER BY e.id DESC LIMIT 1",
                            {rule, machine, code});
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

std::optional<AlarmEventRow> alarm_event(Database& db, std::int64_t id) {
  auto found = events_where(db, " WHERE e.id = ?", {id});
  if (found.empty()) return std::nullopt;
  return std::move(found.front());
}

Listed<AlarmEventRow> alarm_events(Database& db, const AlarmEventFilter& filter, const Page& page) {
  Where where;
  if (filter.open_only) where.add("e.cleared_ms IS NULL AND e.acknowledged_ms IS NULL");
  if (filter.machine != 0) where.add("e.machine_id = ?", filter.machine);
  where.page("e.id", page);
  return listed<AlarmEventRow>(db, kEvent, where, "e.id", page, event_of, [](const AlarmEventRow& row) { return row.id; });
}

std::int64_t insert_alarm_event(Database& db, const AlarmEventRow& event) {
  return *db.integer("INSERT INTO alarm_events (rule_id, machine_id, code, alarm_id, first_ms, last_ms) VALUES (?, ?, ?, ?, "
                     "?, ?) RETURNING id",
                     {event.rule, event.machine, event.code, event.alarm, event.first_ms, event.last_ms});
}

void repeat_alarm_event(Database& db, std::int64_t id, std::int64_t alarm, std::int64_t at_ms) {
  db.execute("UPDATE alarm_events SET times = times + 1, alarm_id = ?, last_ms = ?, cleared_ms = NULL WHERE id = ?",
             {alarm, at_ms, id});
}

void clear_alarm_events(Database& db) {
  db.execute("UPDATE alarm_events SET cleared_ms = (SELECT a.cleared_ms FROM alarms a WHERE a.id = alarm_events.alarm_id) "
             "WHERE cleared_ms IS NULL AND EXISTS (SELECT 1 FROM alarms a WHERE a.id = alarm_events.alarm_id AND "
             "a.cleared_ms IS NOT NULL)");
}

bool acknowledge_alarm_event(Database& db, std::int64_t id, const std::string& by, const std::string& note,
                             std::int64_t at_ms) {
  return db.execute("UPDATE alarm_events SET acknowledged_ms = ?, acknowledged_by = ?, acknowledged_note = ? WHERE id = ? "
                    "AND acknowledged_ms IS NULL",
                    {at_ms, by, note, id}) > 0;
}

std::vector<AlarmEventRow> alarm_events_to_escalate(Database& db, std::int64_t now_ms) {
  return events_where(db,
                      " WHERE e.cleared_ms IS NULL AND e.acknowledged_ms IS NULL AND e.escalated_ms IS NULL AND r.enabled "
                      "= 1 AND r.removed_ms IS NULL AND r.escalate_after_s > 0 AND e.first_ms + r.escalate_after_s * 1000 "
                      "<= ? ORDER BY e.id",
                      {now_ms});
}

void mark_escalated(Database& db, std::int64_t id, std::int64_t at_ms) {
  db.execute("UPDATE alarm_events SET escalated_ms = ? WHERE id = ?", {at_ms, id});
}

std::int64_t insert_notice(Database& db, const NoticeRow& notice) {
  return *db.integer("INSERT INTO notices (event_id, kind, step, target, body, state, next_ms) VALUES (?, ?, ?, ?, ?, ?, ?) "
                     "RETURNING id",
                     {notice.event, notice.kind, notice.step, notice.target, notice.body, notice.state, notice.next_ms});
}

std::vector<NoticeRow> notices_due(Database& db, std::int64_t now_ms, int at_most) {
  return notices_where(db, "WHERE state = 'waiting' AND (next_ms <= ? OR next_ms > ?) ORDER BY next_ms, id LIMIT " +
                           std::to_string(at_most),
                       {now_ms, now_ms + kFarMs});
}

std::vector<NoticeRow> notices_of(Database& db, std::int64_t event) {
  return notices_where(db, "WHERE event_id = ? ORDER BY id", {event});
}

void update_notice(Database& db, const NoticeRow& notice) {
  db.execute("UPDATE notices SET state = ?, attempts = ?, next_ms = ?, sent_ms = ?, problem = ? WHERE id = ?",
             {notice.state, notice.attempts, notice.next_ms, notice.sent_ms, notice.problem, notice.id});
}

std::int64_t notices_since(Database& db, std::int64_t rule, std::int64_t from_ms) {
  return db.integer("SELECT COUNT(DISTINCT n.event_id) FROM notices n JOIN alarm_events e ON e.id = n.event_id WHERE "
                    "e.rule_id = ? AND n.step = 'first' AND e.first_ms >= ?",
                    {rule, from_ms})
      .value_or(0);
}

}  // namespace headstock::db
