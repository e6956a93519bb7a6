// The record of what state a machine was in, without holes: every instant since the machine was first heard
// of belongs to exactly one interval. What the machine said wins over what the server concluded from its
// silence. Store thread.
#pragma once

#include <cstdint>
#include <string>

#include "db/database.hpp"

namespace headstock::fleet {

enum class Witness { machine, server };

/// From `at_ms` on the machine is in this state. May arrive late and out of order.
void record_state(db::Database& db, std::int64_t machine, const std::string& state, const std::string& mode,
                  std::int64_t at_ms, Witness witness);
/// Nothing heard since `last_heard_ms`: `unknown` from then on (or `off` when it said good-bye).
void record_silence(db::Database& db, std::int64_t machine, const std::string& state,
                    std::int64_t last_heard_ms);
/// Heard again. @param same_boot the machine had run on: only the link was lost, so the state before the
/// silence went on (and late events will refine it). Otherwise the silence stays in the record until the
/// machine's first word.
void record_return(db::Database& db, std::int64_t machine, bool same_boot, std::int64_t at_ms);
/// At server start: every machine was silent since it was last seen.
void close_after_restart(db::Database& db);

}  // namespace headstock::fleet
