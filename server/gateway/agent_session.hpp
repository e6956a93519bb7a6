// One accepted connection: who it is, and what it says. Private to gateway/.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "protocol/wire/certificates.hpp"
#include "protocol/wire/connection.hpp"
#include "protocol/wire/messages.hpp"
#include "server/gateway/gateway.hpp"

namespace headstock::server {

class AgentSession;

/// What a session needs of the gateway.
class SessionOwner {
 public:
  virtual ~SessionOwner() = default;
  virtual bool stopped() const = 0;
  virtual GatewayHost& host() = 0;
  virtual const GatewayOptions& options() const = 0;
  virtual wire::IssuedCertificate sign(const std::string& request_pem, std::int64_t machine) = 0;
  virtual const std::string& ca_pem() const = 0;
  virtual std::shared_ptr<AgentSession> session_of(std::int64_t machine) = 0;
  /// The agent is who it says and takes the machine's place.
  virtual void greeted(const std::shared_ptr<AgentSession>& session, const wire::Hello& hello) = 0;
  virtual void gone(const std::shared_ptr<AgentSession>& session) = 0;
  virtual void on_credit(AgentSession& session, const wire::Frame& frame, const wire::Credit& credit) = 0;
  virtual void on_result(AgentSession& session, const wire::TransferResult& result) = 0;
};

class AgentSession : public std::enable_shared_from_this<AgentSession> {
 public:
  AgentSession(std::shared_ptr<SessionOwner> owner, std::shared_ptr<wire::Connection> connection);

  boost::asio::awaitable<void> run();
  std::int64_t machine() const { return machine_; }
  bool open() const { return greeted_ && connection_->open(); }
  const std::shared_ptr<wire::Connection>& connection() const { return connection_; }
  std::uint32_t next_stream() { return ++streams_; }
  /// Tells the agent why, then closes.
  void refuse(const std::string& reason, const std::string& text = {});

  boost::asio::awaitable<MachineAnswer> ask(wire::Type type, wire::Command command);
  boost::asio::awaitable<nlohmann::json> write_data(nlohmann::json write);  // data_exchange.cpp
  boost::asio::awaitable<ProgramText> get(std::uint64_t transfer, std::string name);

 private:
  struct Answer {
    explicit Answer(const boost::asio::any_io_executor& executor) : arrived(executor) {}
    wire::Signal arrived;
    bool done = false;
    MachineAnswer answer;
  };
  struct Writing {
    explicit Writing(const boost::asio::any_io_executor& executor) : arrived(executor) {}
    wire::Signal arrived;
    std::optional<nlohmann::json> result;
  };
  /// What waits for the store: events, a census or a report of values.
  struct Told {
    wire::Type type;
    nlohmann::json body;
  };
  struct Reading {
    explicit Reading(const boost::asio::any_io_executor& executor) : arrived(executor) {}
    wire::Signal arrived;
    bool done = false;
    ProgramText program;
  };

  boost::asio::awaitable<void> enrol();
  boost::asio::awaitable<bool> identify();
  boost::asio::awaitable<bool> greet();
  boost::asio::awaitable<bool> takes_the_place();
  boost::asio::awaitable<void> watch();
  boost::asio::awaitable<void> store_loop();
  boost::asio::awaitable<void> certificate_stored(std::string serial);
  void handle(const wire::Frame& frame);
  void on_events(const wire::Frame& frame);
  void newest_to_store(wire::Type type, nlohmann::json body);
  boost::asio::awaitable<void> store(Told& told);
  void on_data(const wire::Frame& frame);
  void on_result(const wire::TransferResult& result);
  void renew(const wire::Enrol& request);
  boost::asio::awaitable<void> program_requested(std::uint64_t request, std::string name);
  bool json_body(const wire::Frame& frame, nlohmann::json& body);
  void give_up_answers();
  void on_data_result(const wire::Frame& frame);

  std::shared_ptr<SessionOwner> owner_;
  std::shared_ptr<wire::Connection> connection_;
  wire::Signal to_store_, tick_;
  std::int64_t machine_ = 0;
  std::string serial_, renewed_serial_, spool_id_;
  bool greeted_ = false;
  int requests_under_way_ = 0;
  std::uint32_t streams_ = 0;
  std::uint64_t asked_ = 0, pings_ = 0;
  std::map<std::uint64_t, std::shared_ptr<Answer>> answers_;
  std::map<std::uint32_t, std::shared_ptr<Reading>> readings_;
  std::map<std::uint64_t, std::uint32_t> reading_streams_;
  std::deque<Told> told_;  // in the order in which it was said
  std::map<std::uint64_t, std::shared_ptr<Writing>> writings_;
  std::chrono::steady_clock::time_point last_live_{};
};

}  // namespace headstock::server
