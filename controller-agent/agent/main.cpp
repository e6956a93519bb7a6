// `headstock-agent`: the CNC of one machine; and `headstock-agent panel`, its buttons.
#include <signal.h>

#include <boost/asio/signal_set.hpp>
#include <cstdlib>
#include <iostream>

#include "agent/agent.hpp"
#include "agent/panel_client.hpp"
#include "protocol/process/log.hpp"
#include "protocol/process/options.hpp"

namespace {

using headstock::agent::AgentOptions;
using headstock::agent::Clock;
using headstock::options::Refusal;

/// Decimal, octal or hexadecimal, as of every option that takes a number. 0: it is no port.
int port_of(const std::string& text) {
  char* end = nullptr;
  const long port = std::strtol(text.c_str(), &end, 0);
  return !text.empty() && *end == '\0' && port >= 1 && port <= 65'535 ? static_cast<int>(port) : 0;
}

/// `HOST:PORT`; an empty text means: no server.
void read_server(const std::string& text, AgentOptions& options) {
  if (text.empty()) {
    options.host.clear();
    return;
  }
  const auto colon = text.rfind(':');
  const int port = colon == std::string::npos ? 7878 : port_of(text.substr(colon + 1));
  if (port == 0) throw Refusal("--server", "takes HOST:PORT, not '" + text + "'");
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
    throw Refusal(
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
  headstock::options::Program app(
      "The CNC of one machine. Nothing on the network starts motion before remote operation is armed here.", "headstock-agent");
  app.version(std::string("headstock-agent ") + HEADSTOCK_VERSION);
  AgentOptions options;
  std::string server = "127.0.0.1:7878", clock = "real", dnc;
  std::vector<std::string> settings, words;
  std::filesystem::path panel_folder;
  app.option("--data", options.data, "Folder for everything this machine keeps");
  app.option("--machine", options.machine_file, "Machine file (TOML); kept, so that a restart needs none");
  app.option("--server", server, "HOST:PORT of headstock-server; empty: work alone").shows_default();
  app.option("--enrol", options.token, "One-time token of the server, the first time");
  app.option("--set", settings, "gcode_system=A|B|C, lenient=true|false, decimal_point=standard|pocket");
  app.option("--drip-buffer", options.drip_buffer_bytes, "Bytes kept ahead of a drip-feed").shows_default();
  app.option("--clock", clock, "real, or fast: simulated drives only, periods as fast as possible")
      .one_of({"real", "fast"});
  app.option("--dnc", dnc,
             "The machine's own line for other DNC software: PORT[,line=9600-8-N-1-software][,code=iso] …, "
             "PORT a device, tcp://HOST:PORT, rfc2217://HOST:PORT or listen://ADDRESS:PORT");
  app.flag("--set-aside-damaged", options.set_aside_damaged,
           "Keep a damaged event spool for rescue and start with an empty one");
  auto panel = app.add_command("panel", "The machine's panel: " + headstock::agent::panel_help());
  panel.option("--data", panel_folder, "The agent's data folder").required();
  panel.option("command", words, "Button, and what it takes");
  app.callback([&] {
    if (panel.called()) return;
    if (options.data.empty()) throw Refusal::missing("--data");
    read_server(server, options);
    if (!dnc.empty()) {
      options.dnc.emplace();
      const std::string wrong = headstock::agent::read_dnc_settings(dnc, *options.dnc);
      if (!wrong.empty()) throw Refusal("--dnc", wrong);
    }
    for (const std::string& setting : settings) read_setting(setting, options.switches);
  });
  if (const auto ended = app.parse(argc, argv, 1)) return *ended;
  if (panel.called()) return headstock::agent::run_panel(panel_folder, words);
  options.clock = clock == "fast" ? Clock::fast : Clock::real;
  return run_agent(options);
}
