// The agent's side of the connection to the server: enrols, connects, reports what happens and takes programs
// and commands.
//
// Everything runs on the thread of one io_context, which the caller runs. The link reconnects for ever with a
// bounded, jittered back-off; it never starts motion: a drip-feed goes on *receiving* after a reconnect, and
// that is all.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "operation/controller.hpp"
#include "program/source.hpp"

namespace boost::asio {
class io_context;
}

namespace headstock::link {

class Spool;
class ProgramMemory;

struct LinkOptions {
  std::string host = "127.0.0.1";
  std::uint16_t port = 7878;
  std::filesystem::path pki_folder;          ///< key, certificate and the pinned CA of this agent
  std::string enrolment_token;               ///< `HS1-…`; used once, when there is no certificate yet
  std::string software = "headstock-agent";  ///< shown in the server's machine page
  std::string machine_name;                  ///< what the machine calls itself
  std::string profile;                       ///< `fanuc-0i-t` …
  std::vector<std::string> axes;
  std::string machine_toml;  ///< the machine file, so that the server checks with the same limits; <= 64 KiB
  std::chrono::milliseconds live_interval{200};  ///< >= 100
  std::chrono::milliseconds trail_interval{40};  ///< positions for the tool path
  std::chrono::milliseconds ping_interval{2'000};
  std::chrono::milliseconds silence_limit{6'000};  ///< nothing heard for so long: the link is lost
  std::chrono::milliseconds reconnect_min{250}, reconnect_max{15'000};
  std::size_t drip_buffer_bytes = 1u << 20;  ///< 64 KiB…64 MiB
};

/// What the link shows of itself (local panel, logs).
struct LinkStatus {
  bool connected = false;
  std::string detail;             ///< "connected", or why not, for a person
  std::int64_t machine = 0;       ///< id the server gave, 0: not enrolled
  std::uint64_t connections = 0;  ///< since start
  std::uint64_t events_pending = 0;
};

/// Sent by the server when the connection stands.
struct ServerSettings {
  std::int64_t machine = 0;
  std::int64_t server_time_ms = 0;
  std::uint64_t parts_required = 0;
};

/// The machine the link speaks for. All calls come on the io_context's thread and must return within
/// milliseconds.
class LinkHost {
 public:
  virtual ~LinkHost() = default;
  virtual operation::Live live() = 0;
  /// Hash of the selected program, "" when none or unknown; goes out with live().
  virtual std::string selected_sha256() = 0;
  /// A command from the network; the controller refuses what is not armed.
  virtual operation::CommandResult command(const operation::Command& command, const std::string& user) = 0;
  virtual operation::CommandResult select(const std::string& name, const std::string& user) = 0;
  /// A drip-feed is offered. The host keeps the source while the program runs and destroys it at its end or
  /// on reset; destroying it before `end` was read ends the transfer with the reason "closed_by_machine".
  virtual operation::CommandResult open_stream(const std::string& name, const std::string& sha256,
                                               std::unique_ptr<program::Source> stream,
                                               std::uint64_t total_bytes) = 0;
  /// The server's answer to Link::request(); when it accepts, open_stream() comes with this program, before or after.
  virtual void request_answered(const std::string& name, const operation::CommandResult& answer) = 0;
  /// Offsets, parameters and variables written from the server; `done` is called on this thread with the
  /// data_result (protocol/wire/README.md, without its id) when it is on the disk and read back, or refused.
  virtual void write_data(const nlohmann::json& request, std::function<void(nlohmann::json)> done);
  /// The body of a data_report as it is on the disk; null: this host keeps no data.
  virtual nlohmann::json data_report();
  /// Events were committed to the spool.
  virtual void events_committed() {}
  /// The connection stands.
  virtual void link_up(const ServerSettings& settings) = 0;
  /// The connection is lost: remote arming ends here.
  virtual void link_lost(const std::string& reason) = 0;
};

class Link {
 public:
  /// All references must outlive the link. Throws std::runtime_error for unusable options (pki_folder, token
  /// format).
  Link(boost::asio::io_context& io, LinkOptions options, LinkHost& host, Spool& spool, ProgramMemory& memory);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void start();
  /// DNC mode: asks the server to feed the released program of this name; LinkHost::request_answered() has its word.
  /// Any thread. @return false when there is no link.
  bool request(const std::string& name);
  /// Tells the server that this agent is being switched off ("shutdown"), which is not a lost link. The io_context must
  /// run on for a moment; stop() comes next. @return false when there is nobody to tell.
  bool say_good_bye();
  /// Is the good-bye still on its way?
  bool connection_open() const;
  /// Ends the connection; no call of the host afterwards. On the io_context's thread, or when it does not
  /// run.
  void stop();
  /// Any thread.
  LinkStatus status() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace headstock::link
