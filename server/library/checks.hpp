// Would this machine run this text? The interpreter and the kernel in virtual time say so, on a worker,
// before any machine sees it; the answer is kept for (content, machine configuration, reported offsets,
// checker version).
#pragma once

#include <array>
#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "db/blobs.hpp"
#include "db/machine_store.hpp"
#include "db/program_store.hpp"
#include "server/access/role.hpp"

namespace headstock::db {
class Store;
class Pool;
}  // namespace headstock::db

namespace headstock::library {

struct Finding {
  std::int64_t line = 0, column = 0;
  std::string code, en, zh;
};
struct AxisBounds {
  std::string axis;
  double min_mm = 0, max_mm = 0;
};  ///< machine coordinates

struct CheckResult {
  bool ok = false;
  std::vector<Finding> findings;  ///< at most 100
  double time_s = 0, cutting_s = 0, length_mm = 0;
  bool timed = true;  ///< false: stopped at the effort limit; the figures are of the part done
  std::int64_t blocks = 0;
  std::vector<AxisBounds> bounds;
  std::vector<std::int64_t> tools;
  struct Life {
    std::int64_t group = 0;
    std::string unit;  ///< uses seconds
    double need = 0;
  };
  std::vector<Life> life;  ///< what one run takes of the tool life groups
  std::int64_t machine = 0, at_ms = 0;
};
nlohmann::json to_json(const CheckResult& result);  ///< the shape of server/api/README.md
CheckResult check_result_from_json(const nlohmann::json& json);

struct BackplotMove {
  char kind = 'r';
  std::int64_t line = 0;
  std::vector<double> points;
};  ///< points: axes.size() each
struct Backplot {
  std::vector<std::string> axes;
  std::vector<double> start;  ///< where the first move begins
  std::vector<BackplotMove> moves;
  bool truncated = false;
};

/// Everything a check depends on. Copied to a worker.
struct CheckJob {
  std::string file;  ///< the blob
  db::MachineRow machine;
  std::vector<db::OffsetRow> settings;  ///< parameters and variables the machine reported
  std::map<std::string, std::string>
      subprograms;  ///< program name ("O1234", "SHAFT.NC") → blob file, of the same folder
  std::int64_t max_blocks = 50'000'000;
  std::int64_t max_wall_ms = 60'000;  ///< of the timing; beyond it only the language is checked
  const std::atomic<bool>* cancel = nullptr;
};
/// Name and version of what checks; part of the cache's key.
std::string checker_version();
/// Worker. Never throws on bad programs: those are findings.
CheckResult run_check(const CheckJob& job);
Backplot run_backplot(const CheckJob& job, std::int64_t max_points);

/// Where a control that has lost its state can begin again, and with what in front.
struct Restart {
  std::string reason, where;  ///< why not: restart_in_compensation, restart_in_cycle, restart_mode, restart_variables,
                              ///< restart_not_reached, restart_alarm … ; empty: it can
  std::string header;         ///< blocks to be sent in front of the line, for a person to read and change
  std::uint64_t offset = 0;   ///< of the line's first byte
  std::int64_t lines = 0;     ///< of the whole program
};
/// Interprets the program from its first line up to, not including, `line` (from 1), as this machine would.
Restart run_restart(const CheckJob& job, std::int64_t line);

class Checks {
 public:
  Checks(db::Store& store, db::Pool& workers, const db::Blobs& blobs);
  ~Checks();  // asks running checks to stop

  /// From the cache, or by a run; two that ask for the same at once share one run. Refusals: forbidden,
  /// not_found.
  boost::asio::awaitable<CheckResult> check(access::Actor actor, std::int64_t program, std::int64_t revision,
                                            std::int64_t machine);
  /// The cached result only.
  boost::asio::awaitable<std::optional<CheckResult>> known(std::int64_t program, std::int64_t revision,
                                                           std::int64_t machine);
  /// See run_restart(). Refusals: not_found.
  boost::asio::awaitable<Restart> restart(std::int64_t program, std::int64_t revision, std::int64_t machine,
                                          std::int64_t line);
  /// @param machine 0: the default machine of `profile`.
  boost::asio::awaitable<Backplot> backplot(std::int64_t program, std::int64_t revision, std::int64_t machine,
                                            std::string profile, std::int64_t max_points = 200'000);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace headstock::library
