#include "server/access/view_tokens.hpp"

#include "db/hash.hpp"
#include "db/refusal.hpp"
#include "server/access/audit.hpp"

namespace headstock::access {
namespace {

/// "Last used" is for finding forgotten ones; a write with every look would be waste.
constexpr std::int64_t kTouchScreenMs = 60'000;

}  // namespace

NewViewToken create_view_token(db::Database& db, const Actor& actor, const std::string& name,
                               std::optional<std::int64_t> expires_ms, std::int64_t now_ms) {
  demand(actor, Action::manage_users);
  if (name.empty() || name.size() > 100) throw db::Refusal("bad_name", "name");
  if (expires_ms && *expires_ms <= now_ms) throw db::Refusal("bad_value", "expires");
  db::Transaction transaction(db);
  NewViewToken made;
  made.token = db::random_hex(32);
  made.id = db::insert_view_token(db, {0, name, db::sha256_hex(made.token), actor.user, now_ms, expires_ms, std::nullopt});
  record(db, actor, "view_token.create", "view_token:" + std::to_string(made.id), {{"name", name}});
  transaction.commit();
  return made;
}

void revoke_view_token(db::Database& db, const Actor& actor, std::int64_t id, std::int64_t now_ms) {
  demand(actor, Action::manage_users);
  db::Transaction transaction(db);
  if (!db::revoke_view_token(db, id, now_ms)) throw db::Refusal("not_found", "view_token:" + std::to_string(id));
  record(db, actor, "view_token.revoke", "view_token:" + std::to_string(id));
  transaction.commit();
}

std::optional<db::ViewTokenRow> find_view_token(db::Database& db, const std::string& token, std::int64_t now_ms) {
  if (token.size() != 64) return std::nullopt;
  auto row = db::view_token(db, db::sha256_hex(token));
  if (!row || (row->expires_ms && *row->expires_ms <= now_ms)) return std::nullopt;
  if (row->last_used_ms.value_or(0) + kTouchScreenMs < now_ms) db::touch_view_token(db, row->id, now_ms);
  return row;
}

}  // namespace headstock::access
