#include "db/plan_store.hpp"

#include "db/filter.hpp"

namespace headstock::db {
namespace {

constexpr const char* kPlan =
    "SELECT id, port_id, program_id, revision, name, drip, from_line, header, at_ms, state, reason, "
    "transfer_id, by_user, "
    "by_user_id, created_ms, ended_ms FROM port_plans";

PlanRow plan_of(const Row& row) {
  return {row.integer(0), row.integer(1),  row.integer(2),  row.integer(3),
          row.text(4),    row.flag(5),     row.integer(6),  row.text(7),
          row.integer(8), row.text(9),     row.text(10),    row.integer(11),
          row.text(12),   row.integer(13), row.integer(14), row.maybe_integer(15)};
}

constexpr const char* kData =
    "SELECT id, received_id, port_id, machine_id, kind, name, sha256, entries, by_user, punched_ms, "
    "accepted_ms FROM "
    "punched_data";

PunchedDataRow data_of(const Row& row) {
  return {row.integer(0), row.integer(1), row.integer(2), row.integer(3), row.text(4),    row.text(5),
          row.text(6),    row.integer(7), row.text(8),    row.integer(9), row.integer(10)};
}

Value maybe_id(std::int64_t id) {
  return id == 0 ? Value(nullptr) : Value(id);
}

}  // namespace

std::int64_t insert_plan(Database& db, const PlanRow& row) {
  return *db.integer(
      "INSERT INTO port_plans (port_id, program_id, revision, name, drip, from_line, header, at_ms, by_user, "
      "by_user_id, "
      "created_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {row.port, row.program, row.revision, row.name, std::int64_t{row.drip}, row.from_line, row.header,
       row.at_ms, row.by, row.by_id, row.created_ms});
}

void update_plan(Database& db, const PlanRow& row) {
  db.execute("UPDATE port_plans SET state = ?, reason = ?, transfer_id = ?, ended_ms = ? WHERE id = ?",
             {row.state, row.reason, maybe_id(row.transfer), row.ended_ms, row.id});
}

std::optional<PlanRow> plan(Database& db, std::int64_t id) {
  std::optional<PlanRow> found;
  db.each(std::string(kPlan) + " WHERE id = ?", {id}, [&](const Row& row) { found = plan_of(row); });
  return found;
}

Listed<PlanRow> plans(Database& db, std::int64_t port, bool open_only, const Page& page) {
  Where where;
  if (port != 0) where.add("port_id = ?", port);
  if (open_only) where.add("ended_ms IS NULL");
  where.page("id", page);
  return listed<PlanRow>(db, kPlan, where, "id", page, plan_of, [](const PlanRow& row) { return row.id; });
}

std::vector<PlanRow> due_plans(Database& db, std::int64_t until_ms) {
  std::vector<PlanRow> found;
  db.each(std::string(kPlan) + " WHERE ended_ms IS NULL AND at_ms <= ? ORDER BY at_ms, id", {until_ms},
          [&](const Row& row) { found.push_back(plan_of(row)); });
  return found;
}

std::int64_t insert_punched_data(Database& db, const PunchedDataRow& row) {
  return *db.integer(
      "INSERT INTO punched_data (received_id, port_id, machine_id, kind, name, sha256, entries, by_user, "
      "punched_ms, "
      "accepted_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?) RETURNING id",
      {row.received, row.port, maybe_id(row.machine), row.kind, row.name, row.sha256, row.entries, row.by,
       row.punched_ms, row.accepted_ms});
}

std::optional<PunchedDataRow> punched_data(Database& db, std::int64_t id) {
  std::optional<PunchedDataRow> found;
  db.each(std::string(kData) + " WHERE id = ?", {id}, [&](const Row& row) { found = data_of(row); });
  return found;
}

std::optional<PunchedDataRow> punched_data_before(Database& db, const PunchedDataRow& of) {
  std::optional<PunchedDataRow> found;
  db.each(std::string(kData) + " WHERE port_id = ? AND kind = ? AND id < ? ORDER BY id DESC LIMIT 1",
          {of.port, of.kind, of.id}, [&](const Row& row) { found = data_of(row); });
  return found;
}

Listed<PunchedDataRow> punched_data_rows(Database& db, std::int64_t machine, const std::string& kind,
                                         const Page& page) {
  Where where;
  if (machine != 0) where.add("machine_id = ?", machine);
  if (!kind.empty()) where.add("kind = ?", kind);
  where.page("id", page);
  return listed<PunchedDataRow>(db, kData, where, "id", page, data_of,
                                [](const PunchedDataRow& row) { return row.id; });
}

}  // namespace headstock::db
