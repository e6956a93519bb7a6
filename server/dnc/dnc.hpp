// DNC over serial lines: whole programs, drip-feed, punches, requests from the control. Network thread; the
// lines have a thread of their own.
//
// Safety. Only a released revision is sent. A transfer starts because a person asked for it, or because the
// control did (a rule of its port). A lost port, a line error, a restart of the server end it: where to go on
// is a person's decision, with a header that he has seen. What is received changes nothing before somebody
// accepts it.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/plan_store.hpp"
#include "db/port_store.hpp"
#include "db/transfer_store.hpp"
#include "server/access/role.hpp"
#include "server/dnc/port_line.hpp"
#include "server/dnc/start_place.hpp"
#include "server/library/checks.hpp"

namespace headstock::db {
class Store;
class Pool;
class Blobs;
}  // namespace headstock::db

namespace headstock::dnc {

struct PortView {
  db::PortRow row;
  PortState now;
  std::optional<db::PortTransferRow> transfer;  ///< under way, newest progress
  std::vector<db::PortTransferRow> queue;
  /// What the port has measured over all its transfers, and the pacing that follows from it.
  db::PortMeasuresRow measured;
  std::uint32_t window = 0;  ///< most characters under way
  std::int64_t stop_margin =
      0;  ///< of what the control takes after its DC3; below 0: it cannot be stopped in time
  bool is_agent = false;
};

struct SendWish {
  std::int64_t program = 0, revision = 0;
  bool drip = false;  ///< no limit for a hold, and what goes out may be longer than the control's memory
  std::int64_t from_line = 1;
  std::string header;  ///< of a restart, as the person has confirmed it
  bool queue = false;  ///< when the port is busy: after what is under way (the control must ask with DC1)
  bool armed = false;  ///< waits for the control's DC1 without limit
};

struct RestartAnswer {
  StartPlace place;
  library::Restart restart;
};

/// Where a control that stopped last was, by what left the device.
struct Tail {
  std::string text;       ///< the last characters, readable, as they went out
  std::int64_t line = 0;  ///< of the stored text: the last one that went out whole; 0: none
  bool known = false;     ///< false: nothing of a stored revision was sent
};

/// Agents as ports: the distributor, as far as ports need it. A struct of functions so that tests need no
/// gateway.
struct AgentCarrier {
  std::function<bool(std::int64_t machine)> is_connected;
  std::function<boost::asio::awaitable<db::TransferRow>(
      access::Actor, std::int64_t machine, std::int64_t program, std::int64_t revision, bool drip)>
      send;
  std::function<boost::asio::awaitable<db::TransferRow>(access::Actor, std::int64_t transfer)> cancel;
};

class Dnc {
 public:
  Dnc(boost::asio::io_context& io, db::Store& store, db::Pool& workers, const db::Blobs& blobs,
      library::Checks& checks, std::function<void(std::int64_t port)> changed);
  ~Dnc();
  void set_agents(AgentCarrier agents);
  /// Progress of a transfer to a machine's agent.
  void agent_transfer(const db::TransferRow& row);

  /// What the last run left open has failed (server_restarted); listening ports are opened.
  boost::asio::awaitable<void> start();
  /// Looks at the plans every second from now on. Not part of start(): it never ends.
  void watch_the_clock();
  /// Ends everything; the server is stopping.
  void stop();

  std::vector<PortView> views() const;
  /// Throws Refusal{not_found}.
  PortView view(std::int64_t port) const;

  // Records. Refusals as in ports.hpp; port_busy while something is under way.
  boost::asio::awaitable<db::PortRow> create(access::Actor actor, nlohmann::json fields);
  boost::asio::awaitable<db::PortRow> change(access::Actor actor, std::int64_t port, nlohmann::json fields);
  boost::asio::awaitable<void> remove(access::Actor actor, std::int64_t port);

  /// Refusals: forbidden, not_found, not_released, port_busy, cannot_queue (the control would not be asked),
  /// header_missing, no_code, numbers_are_used.
  boost::asio::awaitable<db::PortTransferRow> send(access::Actor actor, std::int64_t port, SendWish wish);
  /// Refusals: not_found, no_machine (nobody knows how the control reads the program), place_not_found.
  boost::asio::awaitable<RestartAnswer> restart(std::int64_t port, std::int64_t program,
                                                std::int64_t revision, StartWish wish);
  /// What went out of a transfer, from the stored revision, the header and the settings of the time.
  boost::asio::awaitable<Tail> tail(std::int64_t transfer);

  /// Sends at a time, on this person's behalf, if the port is there and the person may still do it then. Only
  /// where the control has to ask with DC1: nothing begins at a machine because of a clock. A plan whose time
  /// passed while the server was not running is missed, never made up for. Refusals: as send, in_the_past.
  boost::asio::awaitable<db::PlanRow> plan(access::Actor actor, std::int64_t port, SendWish wish,
                                           std::int64_t at_ms);
  boost::asio::awaitable<db::PlanRow> cancel_plan(access::Actor actor, std::int64_t plan);

  boost::asio::awaitable<db::PortTransferRow> receive(access::Actor actor, std::int64_t port);
  /// Refusals: forbidden, not_found, nothing_under_way.
  void pause(const access::Actor& actor, std::int64_t port);
  void resume(const access::Actor& actor, std::int64_t port);
  /// Its own path: asks neither the store nor what else is under way.
  void cancel(const access::Actor& actor, std::int64_t port);
  void unqueue(const access::Actor& actor, std::int64_t port, std::int64_t transfer);
  boost::asio::awaitable<serial::LoopReport> loop_test(access::Actor actor, std::int64_t port,
                                                       std::size_t characters);
  boost::asio::awaitable<MonitorPiece> monitor(std::int64_t port, std::uint64_t after, std::size_t most);

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace headstock::dnc
