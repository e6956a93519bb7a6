// Who is told of alarms, what has been told, and the acknowledgement.
#include "db/alarm_rule_store.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/integrations/alarm_rules.hpp"
#include "server/integrations/notifier.hpp"

namespace headstock::api {

namespace {

using access::Action;
using boost::asio::awaitable;

json number_or_null(std::int64_t id) { return id != 0 ? json(id) : json(nullptr); }

json shape(const db::AlarmRuleRow& rule) {
  return {{"id", rule.id},
          {"name", rule.name},
          {"machine", number_or_null(rule.machine)},
          {"group", number_or_null(rule.group)},
          {"code", rule.code},
          {"after_s", rule.after_s},
          {"email", rule.email},
          {"webhook", rule.webhook},
          {"escalate_after_s", rule.escalate_after_s},
          {"escalate_email", rule.escalate_email},
          {"escalate_webhook", rule.escalate_webhook},
          {"again_after_s", rule.again_after_s},
          {"enabled", rule.enabled}};
}

json shape(const db::AlarmEventRow& event) {
  const auto acknowledged = event.acknowledged_ms
                                ? json{{"at", time_json(*event.acknowledged_ms)}, {"by", event.acknowledged_by}, {"note", event.acknowledged_note}}
                                : json(nullptr);
  return {{"id", event.id},
          {"rule", event.rule_name},
          {"machine", event.machine},
          {"machine_name", event.machine_name},
          {"code", event.code},
          {"text", {{"en", event.text_en}, {"zh", event.text_zh}}},
          {"first", time_json(event.first_ms)},
          {"last", time_json(event.last_ms)},
          {"times", event.times},
          {"cleared", event.cleared_ms ? time_json(*event.cleared_ms) : json(nullptr)},
          {"escalated", event.escalated_ms ? time_json(*event.escalated_ms) : json(nullptr)},
          {"acknowledged", acknowledged}};
}

json shape(const db::NoticeRow& notice) {
  return {{"id", notice.id},           {"kind", notice.kind},
          {"step", notice.step},       {"target", notice.target},
          {"state", notice.state},     {"attempts", notice.attempts},
          {"sent", notice.sent_ms ? time_json(*notice.sent_ms) : json(nullptr)},
          {"problem", notice.problem}};
}

template <class Rows>
json alarm_items(const Rows& rows) {
  json items = json::array();
  for (const auto& row : rows) items.push_back(shape(row));
  return items;
}

std::int64_t rule_number(const Call& call, const char* name, std::int64_t fallback) {
  const auto found = call.body.find(name);
  if (found == call.body.end() || found->is_null()) return fallback;
  return call.body_number(name);
}

db::AlarmRuleRow rule_of(const Call& call, std::int64_t id) {
  db::AlarmRuleRow rule;
  rule.id = id;
  rule.name = call.body_text("name");
  rule.machine = rule_number(call, "machine", 0);
  rule.group = rule_number(call, "group", 0);
  rule.code = call.body_text("code", "");
  rule.after_s = rule_number(call, "after_s", 0);
  rule.email = call.body_text("email", "");
  rule.webhook = call.body_text("webhook", "");
  rule.escalate_after_s = rule_number(call, "escalate_after_s", 0);
  rule.escalate_email = call.body_text("escalate_email", "");
  rule.escalate_webhook = call.body_text("escalate_webhook", "");
  rule.again_after_s = rule_number(call, "again_after_s", 300);
  const auto enabled = call.body.find("enabled");
  if (enabled != call.body.end() && !enabled->is_boolean()) throw Refused("bad_request", "enabled");
  rule.enabled = enabled == call.body.end() || enabled->get<bool>();
  return rule;
}

json shape(const integrations::MessageSettings& settings) {
  return {{"mail_url", settings.mail.url},
          {"mail_user", settings.mail.user},
          {"mail_password_set", !settings.mail.password.empty()},
          {"mail_from", settings.mail.from},
          {"mail_tls", settings.mail.demand_tls},
          {"webhook_secret_set", !settings.webhook_secret.empty()},
          {"link", settings.link}};
}

void rule_routes(Services& s, std::vector<Route>& routes) {
  const Need need = needs(Action::edit_alarm_rules);
  routes.push_back({.method = Method::get, .pattern = "/alarm-rules", .role = Role::viewer, .summary = "Who is told of which alarms",
                    .response = "AlarmRules", .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto rows = co_await s.store.run([](db::Database& db) { return db::alarm_rules(db); });
                      co_return json_reply({{"items", alarm_items(rows)}, {"next", nullptr}});
                    }});
  const auto put = [&s](Call& call, std::int64_t id, unsigned status) -> awaitable<Reply> {
    auto rule = rule_of(call, id);
    const auto actor = actor_of(call);
    rule.id = co_await s.store.run([&](db::Database& db) { return integrations::put_rule(db, actor, rule); });
    co_return json_reply(shape(rule), status);
  };
  routes.push_back({.method = Method::post, .pattern = "/alarm-rules", .role = need, .summary = "A new rule; alarms from now on",
                    .takes = Takes::json, .request = "AlarmRuleChange", .response = "AlarmRule", .status = 201,
                    .errors = {"bad_name", "bad_value", "not_found"},
                    .handler = [put](Call& call) -> awaitable<Reply> { co_return co_await put(call, 0, 201); }});
  routes.push_back({.method = Method::patch, .pattern = "/alarm-rules/{id}", .role = need, .summary = "Change it (all fields)",
                    .takes = Takes::json, .request = "AlarmRuleChange", .response = "AlarmRule", .errors = {"bad_name", "bad_value"},
                    .handler = [put](Call& call) -> awaitable<Reply> { co_return co_await put(call, call.id("id"), 200); }});
  routes.push_back({.method = Method::del, .pattern = "/alarm-rules/{id}", .role = need, .summary = "Remove it; its events stay",
                    .status = 204, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto actor = actor_of(call);
                      co_await s.store.run([&](db::Database& db) { integrations::remove_rule(db, actor, id, db::now_ms()); });
                      co_return empty_reply();
                    }});
}

void alarm_event_routes(Services& s, std::vector<Route>& routes) {
  routes.push_back({.method = Method::get, .pattern = "/alarm-events", .role = Role::viewer,
                    .summary = "Events of the rules, newest first: an alarm that stays or comes back soon is one",
                    .response = "AlarmEvents",
                    .query = with({{"open", "boolean", "neither cleared nor acknowledged"}, {"machine", "integer", "only this machine"}}, paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      db::AlarmEventFilter filter;
                      filter.open_only = call.text("open") == "true";
                      filter.machine = call.number("machine", 0);
                      const auto page = page_of(call);
                      const auto list = co_await s.store.run([&](db::Database& db) { return db::alarm_events(db, filter, page); });
                      co_return json_reply({{"items", alarm_items(list.items)}, {"next", list.next ? json(std::to_string(*list.next)) : json(nullptr)}});
                    }});
  routes.push_back({.method = Method::get, .pattern = "/alarm-events/{id}/notices", .role = Role::viewer,
                    .summary = "The messages of an event and what became of them", .response = "Notices",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto rows = co_await s.store.run([id](db::Database& db) { return db::notices_of(db, id); });
                      co_return json_reply({{"items", alarm_items(rows)}, {"next", nullptr}});
                    }});
  routes.push_back({.method = Method::post, .pattern = "/alarm-events/{id}/acknowledge", .role = needs(Action::acknowledge_alarm),
                    .summary = "Somebody takes care of it: no escalation", .takes = Takes::json, .request = "Acknowledgement",
                    .response = "AlarmEvent", .errors = {"already_decided"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto note = call.body_text("note", "");
                      const auto actor = actor_of(call);
                      const auto event = co_await s.store.run([&](db::Database& db) {
                        integrations::acknowledge(db, actor, id, note, db::now_ms());
                        return db::alarm_event(db, id);
                      });
                      co_return json_reply(shape(*event));
                    }});
}

void message_routes(Services& s, std::vector<Route>& routes) {
  const Need need = needs(Action::change_settings);
  routes.push_back({.method = Method::get, .pattern = "/settings/messages", .role = need,
                    .summary = "Mail server and webhook secret (passwords are never shown)", .response = "MessageSettings",
                    .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto found = co_await s.store.run([](db::Database& db) { return integrations::message_settings(db); });
                      co_return json_reply(shape(found));
                    }});
  routes.push_back({.method = Method::patch, .pattern = "/settings/messages", .role = need,
                    .summary = "Change them; an empty password or secret keeps the old one", .takes = Takes::json,
                    .request = "MessageSettingsChange", .response = "MessageSettings", .errors = {"bad_value"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      integrations::MessageSettings wanted;
                      wanted.mail = {call.body_text("mail_url", ""), call.body_text("mail_user", ""),
                                     call.body_text("mail_password", ""), call.body_text("mail_from", ""), false};
                      const auto tls = call.body.find("mail_tls");
                      if (tls != call.body.end() && !tls->is_boolean()) throw Refused("bad_request", "mail_tls");
                      wanted.mail.demand_tls = tls != call.body.end() && tls->get<bool>();
                      wanted.webhook_secret = call.body_text("webhook_secret", "");
                      wanted.link = call.body_text("link", "");
                      const auto actor = actor_of(call);
                      const auto found = co_await s.store.run([&](db::Database& db) {
                        integrations::set_message_settings(db, actor, wanted);
                        return integrations::message_settings(db);
                      });
                      co_return json_reply(shape(found));
                    }});
  routes.push_back({.method = Method::post, .pattern = "/settings/messages/test", .role = need,
                    .summary = "Send a test message now", .takes = Takes::json, .request = "TestMessage", .response = "TestMessageResult",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto kind = call.body_text("kind");
                      if (kind != "email" && kind != "webhook") throw Refused("bad_request", "kind");
                      const auto problem = co_await s.notifier.try_out(kind, call.body_text("target"));
                      co_return json_reply({{"delivered", problem.empty()}, {"problem", problem}});
                    }});
}

}  // namespace

std::vector<Route> alarm_rule_routes(Services& s) {
  std::vector<Route> routes;
  rule_routes(s, routes);
  alarm_event_routes(s, routes);
  message_routes(s, routes);
  return routes;
}

}  // namespace headstock::api
