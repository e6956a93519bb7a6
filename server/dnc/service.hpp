// The inside of the service, shared by its files: records and steering in dnc.cpp, what goes out in
// sending.cpp, what comes in in punches.cpp, the clock in plans.cpp, agents as ports in agent_port.cpp.
// Network thread.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "db/plan_store.hpp"
#include "server/dnc/dnc.hpp"
#include "server/dnc/outgoing.hpp"
#include "server/dnc/settings.hpp"

namespace headstock::dnc {

struct Job {
  db::PortTransferRow row;
  OutgoingText text;
  bool armed = false;  ///< waits for the control's DC1 without limit
};

/// One port at work.
struct Unit {
  db::PortRow row;
  PortSettings settings;
  std::vector<RequestRule> rules;
  PortState now;
  std::optional<Job> job;
  bool starting = false;  ///< a request is between its checks and its job
  std::deque<Job> queue;
  bool ended_well = true;          ///< what was under way last
  std::unique_ptr<PortLine> line;  ///< none for an agent
  std::int64_t agent = 0;          ///< the machine whose agent it is; 0: a line
  std::optional<db::TransferRow> to_agent;
  std::int64_t written_ms = 0;
  serial::SendReport last;
  db::PortMeasuresRow measured;
  std::shared_ptr<boost::asio::steady_timer> looping;
  serial::LoopReport loop;
};

struct Dnc::Impl : std::enable_shared_from_this<Impl> {
  Impl(boost::asio::io_context& the_io, db::Store& the_store, db::Pool& the_workers,
       const db::Blobs& the_blobs, library::Checks& the_checks, std::function<void(std::int64_t)> on_change);

  Unit& unit(std::int64_t port);
  static bool busy(const Unit& unit) { return unit.job || unit.starting || unit.looping; }

  // ---- records (dnc.cpp)
  void install(const db::PortRow& row, const std::optional<db::PortMeasuresRow>& measured);
  void on_state(std::int64_t port, PortState now);
  void on_looped(std::int64_t port, const serial::LoopReport& report);

  // ---- out (sending.cpp)
  boost::asio::awaitable<db::PortTransferRow> send(access::Actor actor, std::int64_t port, SendWish wish);
  void start_job(Unit& at, Job job);
  void on_sending(std::int64_t port, const serial::SendReport& report);
  void end_job(Unit& at);
  void next_in_queue(Unit& at);
  /// Permission to send ends for all that waited behind it: a person decides how it goes on.
  void end_queue(Unit& at, const std::string& reason);
  void measure(Unit& at);
  /// Progress is written every five seconds: after a crash it is known how far it had come.
  void write_sometimes(Unit& at);
  void write(const db::PortTransferRow& row);
  boost::asio::awaitable<OutgoingFacts> looked_through(OutgoingText text, PortSettings settings);

  // ---- in (punches.cpp)
  void on_receiving(std::int64_t port, const serial::ReceiveReport& report,
                    const std::shared_ptr<std::string>& text);
  void begin_receiving(Unit& at, const std::string& by);
  boost::asio::awaitable<void> put_away(std::int64_t port, db::PortTransferRow row,
                                        std::shared_ptr<std::string> text, bool closed);
  boost::asio::awaitable<void> answer(std::int64_t port, RequestRule rule, std::string name);

  // ---- by the clock (plans.cpp)
  void watch_the_clock();
  boost::asio::awaitable<void> look_at_plans();
  boost::asio::awaitable<void> carry_out(db::PlanRow plan);

  // ---- agents (agent_port.cpp)
  boost::asio::awaitable<db::PortTransferRow> send_to_agent(access::Actor actor, std::int64_t port,
                                                            SendWish wish);
  void cancel_agent(const access::Actor& actor, const Unit& at);

  boost::asio::io_context& io;
  db::Store& store;
  db::Pool& workers;
  const db::Blobs& blobs;
  library::Checks& checks;
  std::function<void(std::int64_t)> changed;
  AgentCarrier agents;
  LineThread lines;
  boost::asio::steady_timer clock;
  bool stopped = false;
  std::map<std::int64_t, std::unique_ptr<Unit>> units;
};

std::int64_t whole_ms(serial::Duration time);

}  // namespace headstock::dnc
