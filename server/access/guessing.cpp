#include "server/access/guessing.hpp"

#include <algorithm>

#include "db/access_store.hpp"
#include "db/refusal.hpp"

namespace headstock::access {
namespace {

constexpr std::int64_t kLongestLockMs = 3'600'000;
constexpr std::int64_t kForgottenMs = 900'000;

}  // namespace

std::int64_t lock_time_ms(std::int64_t failures, int limit, const SignInPolicy& policy) {
  if (failures < limit) return 0;
  const auto doublings = std::min<std::int64_t>(failures - limit, 20);
  return std::min(policy.lock_ms << doublings, kLongestLockMs);
}

bool is_locked(std::int64_t locked_until_ms, std::int64_t now_ms) {
  return locked_until_ms > now_ms && locked_until_ms - now_ms <= kLongestLockMs;
}

void demand_patient_address(db::Database& db, const std::string& address, std::int64_t now_ms) {
  const auto row = db::failing_address(db, address);
  if (row && is_locked(row->locked_until_ms, now_ms))
    throw db::Refusal("locked_out", std::to_string((row->locked_until_ms - now_ms + 999) / 1000));
}

void count_address_failure(db::Database& db, const std::string& address, const SignInPolicy& policy, std::int64_t now_ms) {
  if (address.empty()) return;
  db::forget_failing_addresses(db, now_ms - kForgottenMs);
  db::AddressRow row = db::failing_address(db, address).value_or(db::AddressRow{address, 0, 0, 0});
  ++row.failures;
  row.last_ms = now_ms;
  if (const auto lock = lock_time_ms(row.failures, policy.address_failures_before_lock, policy); lock > 0)
    row.locked_until_ms = now_ms + lock;
  db::put_failing_address(db, row);
}

}  // namespace headstock::access
