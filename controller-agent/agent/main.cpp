// `headstock-agent`: the CNC of one machine; and `headstock-agent panel`, its buttons.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <boost/asio/signal_set.hpp>
#include <iostream>

#include "agent/agent.hpp"
#include "agent/panel_client.hpp"
#include "protocol/process/log.hpp"

namespace {

using headstock::agent::AgentOptions;
using headstock::agent::Clock;

/// `HOST:PORT`; an empty text means: no server.
void read_server(const std::string& text, AgentOptions& options) {
  if (text.empty()) {
    options.host.clear();
    return;
  }
  const auto colon = text.rfind(':');
  int port = 7878;
  if (colon != std::string::npos && !CLI::detail::lexical_cast(text.substr(colon + 1), port)) port = 0;
  if (port < 1 || port > 65'535) throw CLI::ValidationError("--server", "takes HOST:PORT, not '" + text + "'");
  options.host = text.substr(0, colon);
  options.port = static_cast<std::uint16_t>(port);
}

/// The same switches as the offline tools' `--set`.
void read_setting(const std::string& text, headstock::interp::Switches& switches) {
  const auto equals = text.find('=');
  const std::string key = text.substr(0, equals), value = equals == std::string::npos ? "" : text.substr(equals + 1);
  if (key == "gcode_system" && (value == "A" || value == "B" || value == "C")) {
    switches.gcode_system = value[0];
  } else if (key == "lenient" && (value == "true" || value == "false")) {
    switches.lenient = value == "true";
  } else if (key == "decimal_point" && (value == "standard" || value == "pocket")) {
    using headstock::interp::DecimalPoint;
    switches.decimal_point = value == "pocket" ? DecimalPoint::pocket : DecimalPoint::standard;
  } else {
    throw CLI::ValidationError(
        "--set", "takes gcode_system=A|B|C, lenient=true|false or decimal_point=standard|pocket, not '" + text + "'");
  }
}

int run_agent(const AgentOptions& options) {
  // An agent logs to stderr: its service manager keeps the log.
  headstock::log::send_to(headstock::log::Target::standard_error);
  try {
    headstock::agent::Agent agent(options);
    boost::asio::signal_set signals(agent.io(), SIGINT, SIGTERM);
    signals.async_wait([&](auto error, int) {
      if (!error) agent.stop();
    });
    agent.run();
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "headstock-agent: " << error.what() << "\n";
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  signal(SIGPIPE, SIG_IGN);
  CLI::App app{"The CNC of one machine. Nothing on the network starts motion before remote operation is armed here.",
               "headstock-agent"};
  app.set_version_flag("--version", std::string("headstock-agent ") + HEADSTOCK_VERSION);
  AgentOptions options;
  std::string server = "127.0.0.1:7878", clock = "real", dnc;
  std::vector<std::string> settings, words;
  std::filesystem::path panel_folder;
  app.add_option("--data", options.data, "Folder for everything this machine keeps");
  app.add_option("--machine", options.machine_file, "Machine file (TOML); kept, so that a restart needs none");
  app.add_option("--server", server, "HOST:PORT of headstock-server; empty: work alone")->capture_default_str();
  app.add_option("--enrol", options.token, "One-time token of the server, the first time");
  app.add_option("--set", settings, "gcode_system=A|B|C, lenient=true|false, decimal_point=standard|pocket");
  app.add_option("--drip-buffer", options.drip_buffer_bytes, "Bytes kept ahead of a drip-feed")->capture_default_str();
  app.add_option("--clock", clock, "real, or fast: simulated drives only, periods as fast as possible")
      ->check(CLI::IsMember({"real", "fast"}));
  app.add_option("--dnc", dnc,
                 "The machine's own line for other DNC software: PORT[,line=9600-8-N-1-software][,code=iso] …, "
                 "PORT a device, tcp://HOST:PORT, rfc2217://HOST:PORT or listen://ADDRESS:PORT");
  app.add_flag("--set-aside-damaged", options.set_aside_damaged,
               "Keep a damaged event spool for rescue and start with an empty one");
  CLI::App* panel = app.add_subcommand("panel", "The machine's panel: " + headstock::agent::panel_help());
  panel->add_option("--data", panel_folder, "The agent's data folder")->required();
  panel->add_option("command", words, "Button, and what it takes");
  try {
    app.parse(argc, argv);
    if (panel->parsed()) return headstock::agent::run_panel(panel_folder, words);
    if (options.data.empty()) throw CLI::RequiredError("--data");
    read_server(server, options);
    if (!dnc.empty()) {
      options.dnc.emplace();
      const std::string wrong = headstock::agent::read_dnc_settings(dnc, *options.dnc);
      if (!wrong.empty()) throw CLI::ValidationError("--dnc", wrong);
    }
    for (const std::string& setting : settings) read_setting(setting, options.switches);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  }
  options.clock = clock == "fast" ? Clock::fast : Clock::real;
  return run_agent(options);
}
