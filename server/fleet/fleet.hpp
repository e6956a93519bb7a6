// The machines as they are now: what the gateway hears goes to the store and to those who watch. Network
// thread only.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "db/machine_store.hpp"
#include "server/fleet/changes.hpp"
#include "server/gateway/gateway.hpp"

namespace headstock::db {
class Store;
}
namespace headstock::library {
class Distributor;
}

namespace headstock::fleet {

inline constexpr std::int64_t kSilenceMs = 6'000;  ///< not heard for this long: unknown

class Fleet : public server::GatewayHost {
 public:
  /// Reads the machines and closes what the last run left open. Blocks: call before the network thread runs.
  Fleet(boost::asio::any_io_executor network, db::Store& store, Changes& changes);
  ~Fleet() override;

  /// Where the gateway's news of transfers go.
  void set_distributor(library::Distributor* distributor);

  /// `Live` of one machine as in server/api/README.md, aged to now; null for an unknown id.
  nlohmann::json live_of(std::int64_t machine) const;
  /// All machines by id.
  nlohmann::json all_live() const;
  /// Call once a second: machines that fell silent become unknown and are published so.
  void tick();

  /// Machines were created, changed or removed, programs released: read again what live states show of them.
  boost::asio::awaitable<void> refresh();

  // ---- server::GatewayHost
  boost::asio::awaitable<std::int64_t> redeem_token(std::string secret) override;
  boost::asio::awaitable<void> certificate_issued(std::int64_t machine, std::string serial_hex) override;
  boost::asio::awaitable<bool> certificate_valid(std::int64_t machine, std::string serial_hex) override;
  boost::asio::awaitable<std::string> machine_name(std::int64_t machine) override;
  void connected(std::int64_t machine, const nlohmann::json& hello) override;
  void disconnected(std::int64_t machine, const std::string& reason) override;
  void live(std::int64_t machine, nlohmann::json live) override;
  boost::asio::awaitable<std::uint64_t> events(std::int64_t machine, std::string spool_id,
                                               nlohmann::json events) override;
  boost::asio::awaitable<void> census(std::int64_t machine, nlohmann::json programs) override;
  boost::asio::awaitable<server::MachineAnswer> program_requested(std::int64_t machine, std::string name) override;
  void transfer_changed(const server::TransferState& state) override;
  boost::asio::awaitable<void> data_report(std::int64_t machine, std::string spool_id,
                                           const nlohmann::json& report) override;

  /// Tells who watches that values or requests of this machine have changed.
  void values_changed(std::int64_t machine);
  /// The machine's own parameter switch, as last reported.
  bool parameter_write(std::int64_t machine) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace headstock::fleet
