// What people ask to be written into a machine's pages: rules, second person, and what became of it.
//
//   asked ─ above a limit → waiting ─ another person agrees → sending ─ the machine took it → done
//                              └ withdrawn                        ├ it refused → refused
//                                                                 ├ it was not there → failed
//                                                                 └ the answer was lost → unknown
// unknown ends when the machine reports what it has: its events say whether it was carried out. Nothing waits
// to be written later: a request that could not be delivered has failed, and a person asks again.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "db/value_store.hpp"
#include "server/access/role.hpp"

namespace headstock::db {
class Store;
}

namespace headstock::fleet {

struct NewValueRequest {
  std::int64_t machine = 0;
  std::string origin = "person";  ///< person import copy restore compensation
  std::string why;
  std::vector<db::ValueItem> items;  ///< what, before, after
};

// ---- store thread; each is one transaction with its audit row

/// Refusals: forbidden, not_found, no_values, machine_not_read (it never told what it has), changed_meanwhile
/// (where: the value), value_refused (where: the value and why). @return waiting or sending.
db::ValueRequestRow ask_values(db::Database& db, const access::Actor& actor, const NewValueRequest& request,
                               std::int64_t now_ms);
/// Refusals: forbidden, not_found, already_decided, same_person. @return sending.
db::ValueRequestRow agree(db::Database& db, const access::Actor& actor, std::int64_t id, std::int64_t now_ms);
/// Refusals: forbidden, not_found, already_decided.
db::ValueRequestRow withdraw(db::Database& db, const access::Actor& actor, std::int64_t id,
                             std::int64_t now_ms);
/// @param answer a data_result, or {accepted:false, reason} when there was none
db::ValueRequestRow finish_request(db::Database& db, std::int64_t id, const nlohmann::json& answer,
                                   std::int64_t now_ms);
/// The machine has told all its events and values: what was unknown is known now. @return those that ended.
std::vector<std::int64_t> settle_unknown(db::Database& db, std::int64_t machine, std::int64_t now_ms);
/// The server was stopped in the middle.
void unsettle_after_restart(db::Database& db);
/// The largest step of one person; nothing: none. Refusals: forbidden, bad_value.
void set_value_limit(db::Database& db, const access::Actor& actor, std::int64_t machine,
                     const std::string& kind, std::optional<double> step);
/// Everything the machine has now under a name. Refusals: forbidden, not_found, bad_name.
db::SnapshotRow take_snapshot(db::Database& db, const access::Actor& actor, std::int64_t machine,
                              const std::string& name, std::int64_t now_ms);

/// What would have to be written so that the machine has `wanted` in these pages. Values that the machine has
/// no place for are not in it but counted.
struct Difference {
  std::vector<db::ValueItem> items;  ///< before: the machine's, after: wanted
  std::int64_t without_place = 0;
};
Difference difference(db::Database& db, std::int64_t machine, const db::MachineValues& wanted,
                      const std::string& kind);

// ---- network thread

/// Carries a data_write to the machine and brings its data_result.
using CarryValues =
    std::function<boost::asio::awaitable<nlohmann::json>(std::int64_t machine, nlohmann::json write)>;

class ValueDesk {
 public:
  ValueDesk(db::Store& store, CarryValues carry, std::function<void(std::int64_t machine)> changed)
      : store_(store), carry_(std::move(carry)), changed_(std::move(changed)) {}

  /// Asks and, when one person is enough, writes and reads back.
  boost::asio::awaitable<db::ValueRequestRow> ask(access::Actor actor, NewValueRequest request);
  boost::asio::awaitable<db::ValueRequestRow> agree(access::Actor actor, std::int64_t id);
  /// Of a request that ask_values has just made in somebody else's transaction: writes it and reads it back,
  /// unless it waits for a second person.
  boost::asio::awaitable<db::ValueRequestRow> carry_out(db::ValueRequestRow request);

 private:
  boost::asio::awaitable<db::ValueRequestRow> send(db::ValueRequestRow request);

  db::Store& store_;
  CarryValues carry_;
  std::function<void(std::int64_t)> changed_;
};

}  // namespace headstock::fleet
