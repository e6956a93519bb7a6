#include "server/access/audit.hpp"

#include <nlohmann/json.hpp>

#include "db/time.hpp"

namespace headstock::access {

std::string subject(std::string_view kind, std::int64_t id) {
  return std::string(kind).append(":").append(std::to_string(id));
}

void record(db::Database& db, const Actor& actor, std::string_view action, const std::string& subject,
            std::initializer_list<std::pair<std::string_view, std::string>> detail) {
  nlohmann::json json = nlohmann::json::object();
  for (const auto& [key, value] : detail) json[std::string(key)] = value;
  db::AuditRow row;
  row.at_ms = db::now_ms();
  row.user = actor.user;
  row.address = actor.address;
  row.action = action;
  row.subject = subject;
  row.detail = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  db::append_audit(db, std::move(row));
}

AuditVerdict verify_audit(db::Database& db, const db::AuditHead& seen) {
  AuditVerdict verdict;
  verdict.head = db::audit_head(db);
  verdict.broken = db::first_broken_audit(db);
  if (verdict.broken != 0) {
    verdict.what = db::audit_hash(db, verdict.broken).empty() ? "missing" : "changed";
    return verdict;
  }
  if (seen.id == 0 || (seen.id <= verdict.head.id && db::audit_hash(db, seen.id) == seen.hash)) return verdict;
  verdict.broken = seen.id;
  verdict.what = seen.id > verdict.head.id ? "cut" : "changed";
  return verdict;
}

}  // namespace headstock::access
