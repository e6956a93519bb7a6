#include "db/transfer_store.hpp"

#include "db/filter.hpp"

namespace headstock::db {
namespace {

constexpr const char* kTransfer =
    "SELECT id, distribution_id, machine_id, program_id, revision, name, sha256, kind, state, bytes, total, "
    "reason, by_user, "
    "created_ms, started_ms, ended_ms FROM transfers";

TransferRow transfer_of(const Row& row) {
  return {row.integer(0), row.integer(1),  row.integer(2),        row.integer(3),
          row.integer(4), row.text(5),     row.text(6),           row.text(7),
          row.text(8),    row.integer(9),  row.integer(10),       row.text(11),
          row.text(12),   row.integer(13), row.maybe_integer(14), row.maybe_integer(15)};
}

}  // namespace

std::int64_t insert_distribution(Database& db, const DistributionRow& distribution) {
  return *db.integer(
      "INSERT INTO distributions (program_id, revision, by_user, at_ms) VALUES (?, ?, ?, ?) RETURNING id",
      {distribution.program, distribution.revision, distribution.by, distribution.at_ms});
}

std::optional<DistributionRow> distribution(Database& db, std::int64_t id) {
  std::optional<DistributionRow> found;
  db.each("SELECT id, program_id, revision, at_ms, by_user FROM distributions WHERE id = ?", {id},
          [&](const Row& row) {
            found = DistributionRow{row.integer(0), row.integer(1), row.integer(2),
                                    row.integer(3), row.text(4),    {}};
          });
  if (found)
    db.each(std::string(kTransfer) + " WHERE distribution_id = ? ORDER BY id", {id},
            [&](const Row& row) { found->transfers.push_back(transfer_of(row)); });
  return found;
}

std::int64_t insert_transfer(Database& db, const TransferRow& transfer) {
  const Value distribution = transfer.distribution == 0 ? Value(nullptr) : Value(transfer.distribution);
  return *db.integer(
      "INSERT INTO transfers (distribution_id, machine_id, program_id, revision, name, sha256, kind, state, "
      "bytes, total, reason, "
      "by_user, created_ms, started_ms, ended_ms) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) "
      "RETURNING id",
      {distribution, transfer.machine, transfer.program, transfer.revision, transfer.name, transfer.sha256,
       transfer.kind, transfer.state, transfer.bytes, transfer.total, transfer.reason, transfer.by,
       transfer.created_ms, transfer.started_ms, transfer.ended_ms});
}

void update_transfer(Database& db, const TransferRow& transfer) {
  db.execute(
      "UPDATE transfers SET state = ?, bytes = ?, reason = ?, started_ms = ?, ended_ms = ? WHERE id = ?",
      {transfer.state, transfer.bytes, transfer.reason, transfer.started_ms, transfer.ended_ms, transfer.id});
}

std::optional<TransferRow> transfer(Database& db, std::int64_t id) {
  std::optional<TransferRow> found;
  db.each(std::string(kTransfer) + " WHERE id = ?", {id}, [&](const Row& row) { found = transfer_of(row); });
  return found;
}

Listed<TransferRow> transfers(Database& db, const TransferFilter& filter, const Page& page) {
  Where where;
  if (filter.machine != 0) where.add("machine_id = ?", filter.machine);
  if (filter.open_only) where.add("ended_ms IS NULL");
  where.page("id", page);
  return listed<TransferRow>(db, kTransfer, where, "id", page, transfer_of,
                             [](const TransferRow& row) { return row.id; });
}

}  // namespace headstock::db
