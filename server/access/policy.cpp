#include "server/access/policy.hpp"

#include <charconv>
#include <string>

#include "db/access_store.hpp"
#include "db/refusal.hpp"
#include "server/access/audit.hpp"

namespace headstock::access {
namespace {

struct Setting {
  const char* key;
  const char* name;
  std::int64_t PolicyChange::*value;
  std::int64_t low, high;
};
constexpr Setting kSettings[] = {
    {"access.session_hours", "session_hours", &PolicyChange::session_hours, 1, 168},
    {"access.idle_minutes", "idle_minutes", &PolicyChange::idle_minutes, 0, 1440},
    {"access.least_password", "least_password", &PolicyChange::least_password, 8, 64},
};

}  // namespace

PolicyChange policy_settings(db::Database& db) {
  PolicyChange found;
  for (const Setting& setting : kSettings)
    if (const auto text = db::setting(db, setting.key)) {
      std::int64_t value = 0;
      if (std::from_chars(text->data(), text->data() + text->size(), value).ec == std::errc() && value >= setting.low &&
          value <= setting.high)
        found.*setting.value = value;
    }
  return found;
}

SignInPolicy policy_of(db::Database& db) {
  const PolicyChange set = policy_settings(db);
  SignInPolicy policy;
  policy.session_ms = set.session_hours * 3'600'000;
  policy.idle_ms = set.idle_minutes * 60'000;
  policy.least_password = set.least_password;
  return policy;
}

void set_policy(db::Database& db, const Actor& actor, const PolicyChange& change) {
  demand(actor, Action::change_settings);
  for (const Setting& setting : kSettings)
    if (change.*setting.value < setting.low || change.*setting.value > setting.high)
      throw db::Refusal("bad_value", setting.name);
  if (change.idle_minutes > 0 && change.idle_minutes < 5) throw db::Refusal("bad_value", "idle_minutes");
  db::Transaction transaction(db);
  for (const Setting& setting : kSettings) db::put_setting(db, setting.key, std::to_string(change.*setting.value));
  record(db, actor, "settings.sign_in", "settings",
         {{"session_hours", std::to_string(change.session_hours)},
          {"idle_minutes", std::to_string(change.idle_minutes)},
          {"least_password", std::to_string(change.least_password)}});
  transaction.commit();
}

}  // namespace headstock::access
