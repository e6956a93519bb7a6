#include "server/integrations/notifier.hpp"

#include "db/access_store.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "protocol/process/log.hpp"
#include "server/access/audit.hpp"
#include "server/integrations/alarm_rules.hpp"

namespace headstock::integrations {
namespace {

using boost::asio::awaitable;

constexpr int kAtOnce = 10;
constexpr const char* kTest = R"({"step":"test"})";

/// As short as the coroutine needs it: put aside at the start, put back however it ends.
struct Busy {
  explicit Busy(bool& the_flag) : flag(the_flag) { flag = true; }
  ~Busy() { flag = false; }
  Busy(const Busy&) = delete;
  Busy& operator=(const Busy&) = delete;
  bool& flag;
};

std::string deliver(const MessageSettings& settings, const std::string& kind, const std::string& target,
                    const std::string& body) {
  if (kind == "webhook") return call_webhook(target, body, settings.webhook_secret);
  const std::string link = settings.link.empty() ? "" : settings.link + "/#/alarms?view=events";
  return send_mail(settings.mail, mail_of(body, target, link));
}

bool acceptable_url(const std::string& url, std::initializer_list<std::string_view> schemes) {
  if (url.empty()) return true;
  if (url.size() > 500 || url.find_first_of(" \r\n\"<>") != std::string::npos) return false;
  for (const auto scheme : schemes)
    if (url.starts_with(scheme) && url.size() > scheme.size()) return true;
  return false;
}

}  // namespace

MessageSettings message_settings(db::Database& db) {
  const auto of = [&db](const char* key) { return db::setting(db, key).value_or(""); };
  MessageSettings settings;
  settings.mail = {of("notify.mail_url"), of("notify.mail_user"), of("notify.mail_password"), of("notify.mail_from"),
                   of("notify.mail_tls") == "1"};
  settings.webhook_secret = of("notify.webhook_secret");
  settings.link = of("notify.link");
  return settings;
}

void set_message_settings(db::Database& db, const access::Actor& actor, const MessageSettings& settings) {
  access::demand(actor, access::Action::change_settings);
  if (!acceptable_url(settings.mail.url, {"smtp://", "smtps://"})) throw db::Refusal("bad_value", "mail_url");
  if (!acceptable_url(settings.link, {"http://", "https://"})) throw db::Refusal("bad_value", "link");
  if (settings.mail.from.find_first_of("\r\n") != std::string::npos ||
      (!settings.mail.url.empty() && settings.mail.from.find('@') == std::string::npos))
    throw db::Refusal("bad_value", "mail_from");
  db::Transaction transaction(db);
  db::put_setting(db, "notify.mail_url", settings.mail.url);
  db::put_setting(db, "notify.mail_user", settings.mail.user);
  if (!settings.mail.password.empty()) db::put_setting(db, "notify.mail_password", settings.mail.password);
  db::put_setting(db, "notify.mail_from", settings.mail.from);
  db::put_setting(db, "notify.mail_tls", settings.mail.demand_tls ? "1" : "0");
  if (!settings.webhook_secret.empty()) db::put_setting(db, "notify.webhook_secret", settings.webhook_secret);
  db::put_setting(db, "notify.link", settings.link);
  access::record(db, actor, "settings.messages", "settings",
                 {{"mail_url", settings.mail.url}, {"mail_from", settings.mail.from}, {"link", settings.link}});
  transaction.commit();
}

awaitable<void> Notifier::look() {
  if (busy_) co_return;
  const Busy busy(busy_);
  MessageSettings settings;
  const auto prepare = [&settings](db::Database& db) {
    const auto now = db::now_ms();
    // Nothing to do is the rule: no transaction, no write.
    if (!db.integer("SELECT 1 FROM alarm_rules WHERE removed_ms IS NULL LIMIT 1") &&
        !db.integer("SELECT 1 FROM notices WHERE state = 'waiting' LIMIT 1"))
      return std::vector<db::NoticeRow>();
    evaluate(db, now);
    settings = message_settings(db);
    return db::notices_due(db, now, kAtOnce);
  };
  const auto due = co_await store_.run(prepare);
  for (const db::NoticeRow& notice : due) {
    const auto send = [&settings, &notice] { return deliver(settings, notice.kind, notice.target, notice.body); };
    const std::string problem = co_await worker_.run(send);
    if (!problem.empty()) log::warning("message {} to {} was not delivered: {}", notice.id, notice.target, problem);
    const auto note = [&](db::Database& db) { delivered(db, notice, problem, db::now_ms()); };
    co_await store_.run(note);
  }
}

awaitable<std::string> Notifier::try_out(std::string kind, std::string target) {
  const auto read = [](db::Database& db) { return message_settings(db); };
  const MessageSettings settings = co_await store_.run(read);
  const auto send = [&] { return deliver(settings, kind, target, kTest); };
  co_return co_await worker_.run(send);
}

}  // namespace headstock::integrations
