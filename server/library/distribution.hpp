// Sending released programs to machines: plan first, then send, a state and a reason for every machine. Also
// drip-feeds. Lives on the network thread; the gateway carries the bytes.
#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/blobs.hpp"
#include "db/transfer_store.hpp"
#include "server/access/role.hpp"
#include "server/gateway/gateway.hpp"

namespace headstock::db {
class Store;
}

namespace headstock::library {

class Checks;

/// The gateway as a distribution sees it; a struct of functions so that tests need no sockets.
struct Carrier {
  std::function<bool(std::int64_t machine)> is_connected;
  std::function<boost::asio::awaitable<server::TransferState>(std::uint64_t transfer, std::int64_t machine,
                                                              std::string name, std::string sha256,
                                                              std::shared_ptr<server::BlobReader>)>
      put;
  std::function<boost::asio::awaitable<server::MachineAnswer>(std::uint64_t transfer, std::int64_t machine,
                                                              std::string name, std::string sha256,
                                                              std::shared_ptr<server::BlobReader>)>
      drip;
  /// A drip-feed of before a restart of the server: it goes on when its machine comes and still has it.
  std::function<void(std::uint64_t transfer, std::int64_t machine, std::string name, std::string sha256,
                     std::shared_ptr<server::BlobReader>)>
      offer_again;
  std::function<bool(std::uint64_t transfer, const std::string& reason)> cancel;
};
/// The real one.
Carrier carried_by(server::Gateway& gateway);

/// A blob as the gateway reads it.
std::shared_ptr<server::BlobReader> blob_reader(const db::Blobs& blobs, const std::string& sha256);

class Distributor {
 public:
  using Changed = std::function<void(const db::TransferRow&)>;

  /// @param changed called on the network thread with every progress.
  Distributor(boost::asio::any_io_executor network, db::Store& store, const db::Blobs& blobs, Checks& checks,
              Carrier carrier, Changed changed);
  ~Distributor();

  /// After a server restart, before machines can connect: what was being put has failed (server_restarted),
  /// drip-feeds wait for their machine.
  boost::asio::awaitable<void> resume();

  /// Plans, answers at once, goes on sending. A machine that cannot get it has state "failed" and a reason at
  /// once or later: not_released, not_connected, machine_removed, check_failed, or what the machine said
  /// (memory_full, running …). Refusals: forbidden, not_found, no_machines.
  boost::asio::awaitable<db::DistributionRow> distribute(access::Actor actor, std::int64_t program,
                                                         std::int64_t revision,
                                                         std::vector<std::int64_t> machines);
  /// Opens a drip-feed of a released revision. Refusals: forbidden, not_found, not_released, not_connected,
  /// check_failed, drip_open (the machine has one already), machine_refused (where: its reason).
  boost::asio::awaitable<db::TransferRow> drip(access::Actor actor, std::int64_t machine,
                                               std::int64_t program, std::int64_t revision);
  /// A machine asks for a program by its name (M198, or its operator): the released one of that name, or of that
  /// O number, is fed to it. Refused with not_found, ambiguous (several folders have one), not_released, or as drip().
  boost::asio::awaitable<server::MachineAnswer> requested(std::int64_t machine, std::string name);
  /// Refusals: forbidden, not_found, transfer_over.
  boost::asio::awaitable<db::TransferRow> cancel(access::Actor actor, std::int64_t transfer);
  /// The transfer's row with the newest progress (which is not written to disk at every step).
  boost::asio::awaitable<std::optional<db::TransferRow>> find(std::int64_t transfer);
  /// Open and recent transfers, newest progress included.
  boost::asio::awaitable<db::Listed<db::TransferRow>> list(db::TransferFilter filter, db::Page page);

  // ---- from the gateway, through the fleet
  void transfer_changed(const server::TransferState& state);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace headstock::library
