#include "server/integrations/alarm_rules.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "db/access_store.hpp"
#include "db/machine_store.hpp"
#include "db/refusal.hpp"
#include "db/time.hpp"
#include "server/access/audit.hpp"

namespace headstock::integrations {
namespace {

using nlohmann::json;

constexpr std::int64_t kFirstRetryMs = 60'000;
constexpr std::int64_t kMostAttempts = 8;

std::vector<std::string> addresses(const std::string& list) {
  std::vector<std::string> found;
  std::string one;
  for (const char c : list + ",") {
    if (c == ',' || c == ';' || c == ' ' || c == '\n') {
      if (!one.empty()) found.push_back(std::move(one));
      one.clear();
    } else {
      one += c;
    }
  }
  return found;
}

void demand_emails(const std::string& list, const char* field) {
  for (const std::string& address : addresses(list)) {
    const auto at = address.find('@');
    if (at == std::string::npos || at == 0 || at + 1 == address.size() || address.size() > 254 ||
        address.find_first_of("<>\"\r\n\t\\") != std::string::npos)
      throw db::Refusal("bad_value", field);
  }
}

void demand_urls(const std::string& list, const char* field) {
  for (const std::string& url : addresses(list))
    if ((!url.starts_with("http://") && !url.starts_with("https://")) || url.size() > 2000 || url.find('"') != std::string::npos)
      throw db::Refusal("bad_value", field);
}

void demand_between(std::int64_t value, std::int64_t low, std::int64_t high, const char* field) {
  if (value < low || value > high) throw db::Refusal("bad_value", field);
}

bool concerns(db::Database& db, const db::AlarmRuleRow& rule, std::int64_t machine) {
  if (rule.machine != 0) return rule.machine == machine;
  if (rule.group == 0) return true;
  return db.integer("SELECT 1 FROM machine_group_members WHERE group_id = ? AND machine_id = ?", {rule.group, machine})
      .has_value();
}

enum class Verdict { tell, never, wait };

/// An alarm that must stay for a while is decided when it has stayed or is gone.
Verdict verdict_of(const db::AlarmRuleRow& rule, const db::AlarmRow& alarm, std::int64_t now_ms) {
  const std::int64_t after_ms = rule.after_s * 1000;
  // A machine whose clock is ahead: better told too early than never.
  if (after_ms == 0 || alarm.raised_ms > now_ms) return Verdict::tell;
  if (alarm.cleared_ms) return *alarm.cleared_ms - alarm.raised_ms >= after_ms ? Verdict::tell : Verdict::never;
  return now_ms - alarm.raised_ms >= after_ms ? Verdict::tell : Verdict::wait;
}

json body_of(const db::AlarmEventRow& event, const db::AlarmRow& alarm, const char* step) {
  return {{"step", step},
          {"event", event.id},
          {"rule", event.rule_name},
          {"machine", {{"id", event.machine}, {"name", event.machine_name}}},
          {"code", event.code},
          {"text", {{"en", alarm.text_en}, {"zh", alarm.text_zh}}},
          {"program", alarm.program},
          {"line", alarm.line},
          {"block", alarm.block},
          {"since", db::iso_time(event.first_ms)},
          {"times", event.times}};
}

int enqueue(db::Database& db, const db::AlarmEventRow& event, const std::string& emails, const std::string& webhooks,
            const char* step, const json& body, std::int64_t now_ms) {
  int count = 0;
  const auto put = [&](const char* kind, const std::string& target) {
    db::NoticeRow notice;
    notice.event = event.id;
    notice.kind = kind;
    notice.step = step;
    notice.target = target;
    notice.body = body.dump(-1, ' ', false, json::error_handler_t::replace);
    notice.next_ms = now_ms;
    db::insert_notice(db, notice);
    ++count;
  };
  for (const std::string& target : addresses(emails)) put("email", target);
  for (const std::string& target : addresses(webhooks)) put("webhook", target);
  return count;
}

int tell(db::Database& db, const db::AlarmRuleRow& rule, const db::AlarmRow& alarm, std::int64_t now_ms) {
  const auto last = db::newest_alarm_event(db, rule.id, alarm.machine, alarm.code);
  if (last && last->alarm >= alarm.id) return 0;  // dealt with before
  const bool same = last && (!last->cleared_ms || alarm.raised_ms - *last->cleared_ms < rule.again_after_s * 1000);
  if (same) {
    db::repeat_alarm_event(db, last->id, alarm.id, alarm.raised_ms);
    return 0;
  }
  db::AlarmEventRow event;
  event.rule = rule.id;
  event.machine = alarm.machine;
  event.code = alarm.code;
  event.alarm = alarm.id;
  event.first_ms = event.last_ms = std::min(alarm.raised_ms, now_ms);
  const std::int64_t told = db::notices_since(db, rule.id, now_ms - kStormMs);
  event.id = db::insert_alarm_event(db, event);
  if (told >= kStormLimit) return 0;
  const auto whole = db::alarm_event(db, event.id);
  json body = body_of(*whole, alarm, "first");
  body["storm"] = told + 1 == kStormLimit;  // the last for now: says so
  return enqueue(db, *whole, rule.email, rule.webhook, "first", body, now_ms);
}

int take_rule(db::Database& db, const db::AlarmRuleRow& rule, std::int64_t now_ms) {
  int count = 0;
  std::int64_t decided = rule.since_alarm;
  bool waiting = false;
  for (const db::AlarmRow& alarm : db::alarms_after(db, rule.since_alarm)) {
    const bool fits = code_fits(rule.code, alarm.code) && concerns(db, rule, alarm.machine);
    const Verdict verdict = fits ? verdict_of(rule, alarm, now_ms) : Verdict::never;
    if (verdict == Verdict::tell) count += tell(db, rule, alarm, now_ms);
    waiting = waiting || verdict == Verdict::wait;
    if (!waiting) decided = alarm.id;
  }
  if (decided != rule.since_alarm) db::set_since_alarm(db, rule.id, decided);
  return count;
}

int escalate(db::Database& db, std::int64_t now_ms) {
  int count = 0;
  const auto rules = db::alarm_rules(db);
  for (const db::AlarmEventRow& event : db::alarm_events_to_escalate(db, now_ms)) {
    const auto rule = std::ranges::find(rules, event.rule, &db::AlarmRuleRow::id);
    db::mark_escalated(db, event.id, now_ms);
    if (rule == rules.end()) continue;
    db::AlarmRow alarm;
    alarm.text_en = event.text_en;
    alarm.text_zh = event.text_zh;
    count += enqueue(db, event, rule->escalate_email, rule->escalate_webhook, "escalation",
                     body_of(event, alarm, "escalation"), now_ms);
  }
  return count;
}

}  // namespace

bool code_fits(const std::string& pattern, const std::string& code) {
  if (pattern.empty()) return true;
  // The classic walk with one remembered star.
  std::size_t p = 0, c = 0, star = std::string::npos, mark = 0;
  while (c < code.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      mark = c;
    } else if (p < pattern.size() && pattern[p] == code[c]) {
      ++p;
      ++c;
    } else if (star != std::string::npos) {
      p = star + 1;
      c = ++mark;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

std::int64_t put_rule(db::Database& db, const access::Actor& actor, const db::AlarmRuleRow& rule) {
  access::demand(actor, access::Action::edit_alarm_rules);
  if (rule.name.empty() || rule.name.size() > 100) throw db::Refusal("bad_name", "name");
  if (rule.machine != 0 && rule.group != 0) throw db::Refusal("bad_value", "group");
  if (rule.code.size() > 100) throw db::Refusal("bad_value", "code");
  demand_between(rule.after_s, 0, 86'400, "after_s");
  demand_between(rule.escalate_after_s, 0, 7 * 86'400, "escalate_after_s");
  demand_between(rule.again_after_s, 0, 86'400, "again_after_s");
  demand_emails(rule.email, "email");
  demand_emails(rule.escalate_email, "escalate_email");
  demand_urls(rule.webhook, "webhook");
  demand_urls(rule.escalate_webhook, "escalate_webhook");
  if (addresses(rule.email).empty() && addresses(rule.webhook).empty()) throw db::Refusal("bad_value", "email");
  if (rule.escalate_after_s > 0 && addresses(rule.escalate_email).empty() && addresses(rule.escalate_webhook).empty())
    throw db::Refusal("bad_value", "escalate_email");
  db::Transaction transaction(db);
  if (rule.machine != 0 && !db::machine(db, rule.machine)) throw db::Refusal("not_found", "machine");
  if (rule.group != 0 && !db.integer("SELECT 1 FROM machine_groups WHERE id = ?", {rule.group}))
    throw db::Refusal("not_found", "group");
  const auto rules = db::alarm_rules(db);
  if (rule.id != 0 && std::ranges::find(rules, rule.id, &db::AlarmRuleRow::id) == rules.end())
    throw db::Refusal("not_found", "alarm_rule:" + std::to_string(rule.id));
  const std::int64_t id = db::put_alarm_rule(db, rule);
  access::record(db, actor, "alarm_rule.put", "alarm_rule:" + std::to_string(id),
                 {{"name", rule.name}, {"code", rule.code}, {"email", rule.email}, {"webhook", rule.webhook},
                  {"enabled", rule.enabled ? "yes" : "no"}});
  transaction.commit();
  return id;
}

void remove_rule(db::Database& db, const access::Actor& actor, std::int64_t id, std::int64_t now_ms) {
  access::demand(actor, access::Action::edit_alarm_rules);
  db::Transaction transaction(db);
  if (!db::remove_alarm_rule(db, id, now_ms)) throw db::Refusal("not_found", "alarm_rule:" + std::to_string(id));
  access::record(db, actor, "alarm_rule.remove", "alarm_rule:" + std::to_string(id));
  transaction.commit();
}

void acknowledge(db::Database& db, const access::Actor& actor, std::int64_t event, const std::string& note,
                 std::int64_t now_ms) {
  access::demand(actor, access::Action::acknowledge_alarm);
  db::Transaction transaction(db);
  const auto row = db::alarm_event(db, event);
  if (!row) throw db::Refusal("not_found", "alarm_event:" + std::to_string(event));
  if (!db::acknowledge_alarm_event(db, event, actor.user, note.substr(0, 500), now_ms))
    throw db::Refusal("already_decided", row->acknowledged_by);
  access::record(db, actor, "alarm.acknowledge", "alarm_event:" + std::to_string(event),
                 {{"machine", row->machine_name}, {"code", row->code}, {"note", note.substr(0, 500)}});
  transaction.commit();
}

int evaluate(db::Database& db, std::int64_t now_ms) {
  db::Transaction transaction(db);
  int count = 0;
  for (const db::AlarmRuleRow& rule : db::alarm_rules(db))
    if (rule.enabled) count += take_rule(db, rule, now_ms);
  db::clear_alarm_events(db);
  count += escalate(db, now_ms);
  transaction.commit();
  return count;
}

void delivered(db::Database& db, db::NoticeRow notice, const std::string& problem, std::int64_t now_ms) {
  ++notice.attempts;
  notice.problem = problem.substr(0, 500);
  if (problem.empty()) {
    notice.state = "sent";
    notice.sent_ms = now_ms;
  } else if (notice.attempts >= kMostAttempts) {
    notice.state = "failed";
  } else {
    notice.next_ms = now_ms + (kFirstRetryMs << (notice.attempts - 1));
  }
  db::update_notice(db, notice);
}

}  // namespace headstock::integrations
