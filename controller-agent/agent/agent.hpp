// One machine's agent: the controller, its threads, its memory, its panel and its link to the server, put together.
#pragma once

#include <boost/asio/io_context.hpp>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "agent/data_desk.hpp"
#include "agent/data_folder.hpp"
#include "agent/dnc_settings.hpp"
#include "agent/machine_clock.hpp"
#include "agent/retained.hpp"
#include "agent/storage.hpp"
#include "interpreter/interpreter.hpp"
#include "link/link.hpp"
#include "link/program_memory.hpp"
#include "link/spool.hpp"
#include "machine/machine.hpp"
#include "operation/controller.hpp"

namespace headstock::agent {

class DncInput;
class PanelManual;
class PanelServer;

struct AgentOptions {
  std::filesystem::path data;          ///< --data
  std::filesystem::path machine_file;  ///< --machine; empty: the one kept in the data folder
  std::string host = "127.0.0.1";      ///< --server; empty: works alone
  std::uint16_t port = 7878;
  std::string token;                   ///< --enrol
  Clock clock = Clock::real;           ///< --clock
  interp::Switches switches;           ///< --set
  std::size_t drip_buffer_bytes = 1u << 20;
  bool set_aside_damaged = false;      ///< --set-aside-damaged
  std::optional<DncSettings> dnc;      ///< --dnc: the machine's own line for somebody else's DNC software
};

class Agent final : public link::LinkHost {
 public:
  /// Throws std::runtime_error with a sentence for the person who starts it.
  explicit Agent(AgentOptions options);
  ~Agent() override;

  /// Runs until `stop()`. The calling thread is the network thread.
  void run();
  /// Any thread, signal handlers of the io_context included.
  void stop();
  boost::asio::io_context& io() { return io_; }

  // ---- the local panel (network thread)
  /// One request of the panel: {"do":"arm"} …; the answer is {"accepted":…,"reason":…} or the state.
  std::string panel(const std::string& request);

  // ---- the link
  operation::Live live() override;
  std::string selected_sha256() override;
  operation::CommandResult command(const operation::Command& command, const std::string& user) override;
  operation::CommandResult select(const std::string& name, const std::string& user) override;
  operation::CommandResult open_stream(const std::string& name, const std::string& sha256,
                                       std::unique_ptr<program::Source> stream, std::uint64_t total_bytes) override;
  void request_answered(const std::string& name, const operation::CommandResult& answer) override;
  void write_data(const nlohmann::json& request, std::function<void(nlohmann::json)> done) override;
  nlohmann::json data_report() override;
  void events_committed() override;
  void link_up(const link::ServerSettings& settings) override;
  void link_lost(const std::string& reason) override;

 private:
  operation::CommandResult select(const std::string& name, operation::Origin origin);
  operation::CommandResult switch_dnc(bool on);

  boost::asio::io_context io_;  // outlives everything that may still tell it something
  AgentOptions options_;
  DataFolder folder_;
  machine::Machine machine_;
  std::unique_ptr<link::Spool> spool_;
  std::shared_ptr<link::ProgramMemory> memory_;
  std::unique_ptr<operation::Controller> controller_;
  std::unique_ptr<DataDesk> desk_;
  std::unique_ptr<Storage> storage_;
  std::unique_ptr<MachineClock> clock_;
  std::unique_ptr<DncInput> dnc_;
  std::unique_ptr<link::Link> link_;
  std::unique_ptr<PanelManual> manual_;
  std::unique_ptr<PanelServer> panel_;
  SelectedProgram selected_;
  std::string requested_;       ///< asked for at the panel, to be fed by the server
  std::string request_answer_;  ///< why not: a message key
};

}  // namespace headstock::agent
