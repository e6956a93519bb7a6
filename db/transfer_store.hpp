// Distributions and transfers: what was sent to which machine, how far it got, and why not. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "db/page.hpp"

namespace headstock::db {

struct TransferRow {
  std::int64_t id = 0, distribution = 0, machine = 0, program = 0, revision = 0;
  std::string name, sha256;
  std::string kind;   ///< put, drip
  std::string state;  ///< queued checking sending waiting done failed cancelled
  std::int64_t bytes = 0, total = 0;
  std::string reason;  ///< a message key; empty while nothing is wrong
  std::string by;
  std::int64_t created_ms = 0;
  std::optional<std::int64_t> started_ms, ended_ms;
};

struct DistributionRow {
  std::int64_t id = 0, program = 0, revision = 0, at_ms = 0;
  std::string by;
  std::vector<TransferRow> transfers;
};

std::int64_t insert_distribution(Database& db, const DistributionRow& distribution);
std::optional<DistributionRow> distribution(Database& db, std::int64_t id);
std::int64_t insert_transfer(Database& db, const TransferRow& transfer);
/// Writes state, bytes, reason, started and ended.
void update_transfer(Database& db, const TransferRow& transfer);
std::optional<TransferRow> transfer(Database& db, std::int64_t id);

struct TransferFilter {
  std::int64_t machine = 0;  ///< 0: all
  bool open_only = false;
};
Listed<TransferRow> transfers(Database& db, const TransferFilter& filter, const Page& page);

}  // namespace headstock::db
