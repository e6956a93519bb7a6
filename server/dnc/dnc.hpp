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

#include "db/port_store.hpp"
#include "server/access/role.hpp"
#include "server/dnc/port_line.hpp"
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
  /// What the port has measured on its last transfers.
  std::uint32_t window = 0, most_after_stop = 0, stops = 0;
  std::int64_t starved_ms = 0, longest_hold_ms = 0;
};

struct SendWish {
  std::int64_t program = 0, revision = 0;
  bool drip = false;  ///< no limit for a hold, and what goes out may be longer than the control's memory
  std::int64_t from_line = 1;
  std::string header;  ///< of a restart, as the person has confirmed it
  bool queue = false;  ///< when the port is busy: after what is under way (the control must ask with DC1)
};

class Dnc {
 public:
  Dnc(boost::asio::io_context& io, db::Store& store, db::Pool& workers, const db::Blobs& blobs,
      library::Checks& checks, std::function<void(std::int64_t port)> changed);
  ~Dnc();

  /// What the last run left open has failed (server_restarted); listening ports are opened.
  boost::asio::awaitable<void> start();
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
  /// Refusals: not_found, no_machine (nobody knows how the control reads the program).
  boost::asio::awaitable<library::Restart> restart(std::int64_t port, std::int64_t program,
                                                   std::int64_t revision, std::int64_t line);
  boost::asio::awaitable<db::PortTransferRow> receive(access::Actor actor, std::int64_t port);
  /// Refusals: forbidden, not_found, nothing_under_way.
  void pause(const access::Actor& actor, std::int64_t port);
  void resume(const access::Actor& actor, std::int64_t port);
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
