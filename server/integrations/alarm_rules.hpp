// Which alarms become messages, to whom, and when once more. An alarm that stays, or comes back soon, is one event with
// one message; who does not acknowledge in time makes the next in line hear of it; a storm is cut short. Store thread;
// the time is a parameter.
#pragma once

#include <cstdint>
#include <string>

#include "db/alarm_rule_store.hpp"
#include "server/access/role.hpp"

namespace headstock::integrations {

/// Messages of one rule in ten minutes; what comes above is only in the list.
inline constexpr std::int64_t kStormLimit = 20;
inline constexpr std::int64_t kStormMs = 600'000;

/// Refusals: forbidden, bad_name, bad_value (where: the field), not_found.
std::int64_t put_rule(db::Database& db, const access::Actor& actor, const db::AlarmRuleRow& rule);
void remove_rule(db::Database& db, const access::Actor& actor, std::int64_t id, std::int64_t now_ms);
/// Refusals: forbidden, not_found, already_decided.
void acknowledge(db::Database& db, const access::Actor& actor, std::int64_t event, const std::string& note,
                 std::int64_t now_ms);

/// Does a code fit a rule's pattern (`*` is anything)?
bool code_fits(const std::string& pattern, const std::string& code);

/// New alarms become events and waiting messages, cleared ones end, unanswered ones escalate.
/// @return how many messages were put into the queue.
int evaluate(db::Database& db, std::int64_t now_ms);

/// What a try to deliver came to: sent, tried again after 1, 2, 4 … minutes, or given up after eight.
void delivered(db::Database& db, db::NoticeRow notice, const std::string& problem, std::int64_t now_ms);

}  // namespace headstock::integrations
