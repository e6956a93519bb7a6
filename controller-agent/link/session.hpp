// What the agent says and answers on one standing connection. Private to link/.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "link/drip_feed.hpp"
#include "link/identity.hpp"
#include "link/link.hpp"
#include "link/program_memory.hpp"
#include "link/program_request.hpp"
#include "link/spool.hpp"
#include "protocol/wire/connection.hpp"
#include "protocol/wire/messages.hpp"

namespace headstock::link {

/// What outlives a connection: drip-feeds that are running, and results the server has not yet confirmed.
struct OpenTransfers {
  struct Drip {
    std::shared_ptr<DripFeed> feed;
    std::uint32_t stream = 0;
  };
  std::map<std::uint64_t, Drip> drips;
  std::map<std::uint64_t, wire::TransferResult> unconfirmed;
};

/// Shared by all connections of one Link.
struct LinkParts {
  LinkOptions options;
  LinkHost& host;
  Spool& spool;
  ProgramMemory& memory;
  Identity identity;
  OpenTransfers transfers;
  std::string boot_id;
  bool stopped = false;
  bool leaving = false;  ///< said good-bye: no new connection
  std::function<void()> wake_drips;  ///< posts to the link's thread: some drip-feed has room or ended
  std::function<void()> wake_requests;
  ProgramRequests requests{[this] {
    if (wake_requests) wake_requests();
  }};
};

class Session : public std::enable_shared_from_this<Session> {
 public:
  Session(std::shared_ptr<LinkParts> parts, std::shared_ptr<wire::Connection> connection);

  /// Hello, welcome, then everything until the connection ends. @return whether the server welcomed us.
  boost::asio::awaitable<bool> run();
  /// The reason the server gave for refusing, "" when it did not.
  const std::string& refusal() const { return refusal_; }

  void on_welcome(std::function<void()> call) { on_welcome_ = std::move(call); }

  // ---- poked from outside
  void events_committed();
  void memory_changed();
  void drips_changed();
  void requests_changed();

 private:
  struct Put {
    std::uint64_t transfer = 0, bytes = 0;
    std::string sha256;
    std::unique_ptr<IncomingProgram> incoming;
    std::uint64_t granted_end = 0;
  };

  boost::asio::awaitable<bool> welcomed();
  boost::asio::awaitable<void> report_loop();
  boost::asio::awaitable<void> send_program(std::uint32_t stream, wire::ProgramGet request);
  void handle(const wire::Frame& frame);

  void on_command(const wire::Command& command);
  void on_put(std::uint32_t stream, const wire::TransferOpen& open);
  void on_drip_open(std::uint32_t stream, const wire::TransferOpen& open);
  void on_data(const wire::Frame& frame);
  void on_data_end(std::uint32_t stream, const wire::DataEnd& end);
  void on_cancel(const wire::TransferCancel& cancel);
  void on_renewed(const wire::Enrolled& enrolled);

  void answer(std::uint64_t id, bool accepted, std::string reason);
  void finish_put(std::uint32_t stream, bool ok, const std::string& reason);
  void result(wire::TransferResult result);
  void grant_put(std::uint32_t stream, Put& put);
  void send_credit(wire::Type type, const OpenTransfers::Drip& drip, const DripFeed::Grant& grant);
  DripFeed* drip_of(std::uint32_t stream);
  void pump_events();
  void on_data_write(const wire::Frame& frame);
  void report_data();
  void send_census();
  void send_live();
  void sample_trail();
  void maybe_renew();
  bool active() const { return welcomed_ && connection_->open() && !parts_->stopped; }

  std::shared_ptr<LinkParts> parts_;
  std::shared_ptr<wire::Connection> connection_;
  wire::Signal tick_;
  bool welcomed_ = false;
  std::string refusal_;
  std::int64_t machine_ = 0;
  std::chrono::steady_clock::time_point reported_{};
  std::string reported_values_;  ///< hash of what was reported last on this connection
  std::uint64_t sent_event_ = 0, acknowledged_ = 0, pings_ = 0;
  std::map<std::uint32_t, Put> puts_;
  nlohmann::json trail_ = nlohmann::json::array();
  machine::AxisVector last_position_{};
  std::string renewal_key_;
  std::function<void()> on_welcome_;
};

}  // namespace headstock::link
