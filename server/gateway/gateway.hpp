// The agents' side of the server: accepts their connections, passes what they report to the fleet, and
// carries commands and programs to them. One io_context thread; every callback and coroutine runs on it.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace headstock::server {

/// Result of a command as the machine gave it; `reason` is a message key ("not_armed", "not_connected",
/// "timeout" …).
struct MachineAnswer {
  bool accepted = false;
  std::string reason;
};

/// One program on its way to one machine.
struct TransferState {
  std::uint64_t id = 0;
  std::int64_t machine = 0;
  std::string kind;   ///< "put" or "drip"
  std::string state;  ///< "queued" "sending" "waiting" (link lost, resumable) "done" "failed" "cancelled"
  std::uint64_t bytes = 0, total = 0;
  std::string sha256, reason;
};

/// Reads a stored revision piece by piece, so that 100 MB never sit in memory. May be called for any offset.
class BlobReader {
 public:
  virtual ~BlobReader() = default;
  virtual std::uint64_t size() const = 0;
  virtual std::size_t read(std::uint64_t offset, char* into, std::size_t at_most) = 0;
};

/// What the gateway needs to know and tells; implemented by fleet and library. Calls come on the io_context
/// thread and may suspend (the store works on its own thread).
class GatewayHost {
 public:
  virtual ~GatewayHost() = default;
  /// Enrolment: is this secret a valid one-time token? Consumes it. @return machine id, 0 if not valid.
  virtual boost::asio::awaitable<std::int64_t> redeem_token(std::string secret) = 0;
  /// Remembers the certificate now valid for the machine (older ones are revoked).
  virtual boost::asio::awaitable<void> certificate_issued(std::int64_t machine, std::string serial_hex) = 0;
  /// @return false when the certificate has been revoked or the machine removed.
  virtual boost::asio::awaitable<bool> certificate_valid(std::int64_t machine, std::string serial_hex) = 0;
  virtual boost::asio::awaitable<std::string> machine_name(std::int64_t machine) = 0;
  /// @param hello {software, name, profile, axes:[…], boot_id, spool_id, memory_bytes, census_hash,
  /// machine_toml}
  virtual void connected(std::int64_t machine, const nlohmann::json& hello) = 0;
  virtual void disconnected(std::int64_t machine, const std::string& reason) = 0;
  /// @param live as in server/api/README.md "Live" without what only the server knows (machine, name,
  /// connected, …);
  ///        has `trail` ([[…],…] positions since the last one) and `drip`.
  virtual void live(std::int64_t machine, nlohmann::json live) = 0;
  /// Commits the events in one transaction; repeats (seq not above the last of this spool) are skipped. An
  /// exception closes the connection; the agent sends them again. Never called twice at a time for one
  /// machine.
  /// @param events [{seq, at_ms, kind, …}], oldest first, at most 256; kinds and fields:
  /// protocol/wire/README.md "Events"
  /// @return the highest sequence now committed for this spool.
  virtual boost::asio::awaitable<std::uint64_t> events(std::int64_t machine, std::string spool_id,
                                                       nlohmann::json events) = 0;
  /// @param programs [{name, sha256, bytes, since_ms}], everything resident in the machine now.
  virtual boost::asio::awaitable<void> census(std::int64_t machine, nlohmann::json programs) = 0;
  /// The machine asks for the released program of this name (M198, or its operator): opens a drip-feed to it, or says
  /// why not.
  virtual boost::asio::awaitable<MachineAnswer> program_requested(std::int64_t machine, std::string name) = 0;
  virtual void transfer_changed(const TransferState& state) = 0;
  /// Offsets, tool life, parameters and variables as the machine has them on its disk: {sequence, version,
  /// values, parameter_write}. Comes when every event up to `sequence` was acknowledged, and before any later
  /// one is handed over. `report` lives until it has returned.
  virtual boost::asio::awaitable<void> data_report(std::int64_t /*machine*/, std::string /*spool_id*/,
                                                   const nlohmann::json& /*report*/) {
    co_return;
  }
};

struct GatewayOptions {
  std::string address = "127.0.0.1";
  std::uint16_t port = 7878;            ///< 0: any free port (tests); see port()
  std::string pki_folder;               ///< CA and server certificate, made at first start
  std::vector<std::string> host_names;  ///< more names and addresses for the server's certificate
  // Shorter in tests only.
  std::chrono::milliseconds ping_interval{2'000};
  std::chrono::milliseconds silence_limit{6'000};     ///< nothing heard for so long: the link is lost
  std::chrono::milliseconds handshake_limit{10'000};  ///< from connect to hello or enrol
  std::chrono::milliseconds command_limit{5'000};     ///< answer to a command
  std::size_t connection_limit = 2'000;
};

/// A resident program read back from a machine. `reason` as in MachineAnswer when !ok.
struct ProgramText {
  bool ok = false;
  std::string reason, name, sha256, text;
};

class Gateway {
 public:
  Gateway(boost::asio::io_context& io, GatewayOptions options, GatewayHost& host);
  ~Gateway();

  /// Throws std::runtime_error with a message for the person who starts the server (port in use, unreadable
  /// key).
  void start();
  /// Says good-bye ("shutdown") to every agent, so that it knows it was not cut, and takes no new one; returns when they
  /// are gone or after the time. stop() comes next.
  boost::asio::awaitable<void> shut_down(std::chrono::milliseconds patience);
  /// Closes everything; transfers end as they are (a drip-feed may be offered again after the next start). No
  /// call of the host begins afterwards. On the io_context's thread, or when it does not run.
  void stop();
  std::uint16_t port() const;
  /// For enrolment tokens: lower-case hex SHA-256 of the CA certificate.
  std::string ca_fingerprint() const;

  bool is_connected(std::int64_t machine) const;
  /// Closes the machine's connection (removed, re-enrolled).
  void drop(std::int64_t machine, const std::string& reason);

  boost::asio::awaitable<MachineAnswer> command(std::int64_t machine, std::string action, double value,
                                                std::string user);
  boost::asio::awaitable<MachineAnswer> select(std::int64_t machine, std::string name, std::string user);
  boost::asio::awaitable<MachineAnswer> delete_program(std::int64_t machine, std::string name);
  /// Writes values into the machine's pages. @param write {request, origin, by, values:[{what, before, after}]}
  /// @return the data_result (protocol/wire/README.md); without an answer {accepted:false, reason:"not_connected"
  /// (nothing was sent), "timeout" or "link_lost"}.
  boost::asio::awaitable<nlohmann::json> write_data(std::int64_t machine, nlohmann::json write);
  /// Sends a program into the machine's memory; progress through GatewayHost::transfer_changed.
  boost::asio::awaitable<TransferState> put(std::uint64_t transfer, std::int64_t machine, std::string name,
                                            std::string sha256, std::shared_ptr<BlobReader> content);
  /// Opens a drip-feed; returns when the agent has taken it or refused. It goes on until done, cancelled or
  /// failed.
  boost::asio::awaitable<MachineAnswer> drip(std::uint64_t transfer, std::int64_t machine, std::string name,
                                             std::string sha256, std::shared_ptr<BlobReader> content);
  /// After a restart of the server, before start(): a drip-feed that was not finished. When the machine comes
  /// and still has it (same transfer id) it goes on at the exact byte; when it comes without it, it fails
  /// with "machine_restarted".
  void offer_again(std::uint64_t transfer, std::int64_t machine, std::string name, std::string sha256,
                   std::shared_ptr<BlobReader> content);
  /// Reads a resident program back (at most 64 MiB).
  boost::asio::awaitable<ProgramText> get(std::int64_t machine, std::string name);
  bool cancel(std::uint64_t transfer, const std::string& reason);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace headstock::server
