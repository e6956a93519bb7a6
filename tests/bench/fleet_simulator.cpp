// Many agents without a CNC: real TLS links, real spools, live states and now and then a part. For what a
// server costs with a hall full of machines.
//
//   fleet_simulator --server HOST:PORT --tokens FILE [--updates-per-second 5] [--parts-per-minute 2]
//   [--folder DIR] [--seconds N]
//
// One agent a token (one token a line). With --folder the agents keep their certificates and need no tokens
// the next time.

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "link/link.hpp"
#include "link/live_json.hpp"
#include "link/program_memory.hpp"
#include "link/spool.hpp"
#include "protocol/process/log.hpp"
#include "protocol/process/options.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace {

using namespace headstock;
namespace asio = boost::asio;
namespace fs = std::filesystem;
using std::chrono::milliseconds;

/// Runs the same imaginary part for ever.
class SimulatedMachine final : public link::LinkHost {
 public:
  SimulatedMachine(const fs::path& folder, unsigned number)
      : spool_(folder / "spool.sqlite"), memory_(folder / "programs", 2u << 20) {
    live_.axes = {"X", "Z"};
    live_.state = operation::State::running;
    live_.program_name = "O1001";
    live_.modal = {"G01", "G97", "G99", "G21", "G40", "G54"};
    live_.spindle_commanded_rpm = live_.spindle_actual_rpm = 1200;
    phase_ = number;
    parts_ = std::stoull(spool_.retained("parts").value_or("0"));
  }

  void connect(asio::io_context& io, link::LinkOptions options) {
    link_ = std::make_unique<link::Link>(io, std::move(options), *this, spool_, memory_);
    link_->start();
  }
  void count_part() {
    ++parts_;
    const auto now =
        std::chrono::duration_cast<milliseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
    const operation::PartCounted part{parts_, parts_, "O1001", "", 30};
    const link::NewEvent events[] = {link::to_new_event({now, part})};
    const link::RetainedValue values[] = {{"parts", std::to_string(parts_)}};
    spool_.commit(events, values);
  }
  bool connected() const { return link_->status().connected; }
  std::uint64_t pending() const { return spool_.pending(); }
  std::uint64_t parts() const { return parts_; }

  operation::Live live() override {
    phase_ += 0.02;
    live_.absolute[0] = 20 + 10 * std::sin(phase_);
    live_.absolute[1] = -50 + 40 * std::cos(phase_ / 3);
    live_.at.line = static_cast<std::uint32_t>(phase_) % 500;
    live_.block = "G01 X" + std::to_string(live_.absolute[0]) + " F0.2";
    live_.parts = live_.parts_total = parts_;
    return live_;
  }
  std::string selected_sha256() override { return {}; }
  operation::CommandResult command(const operation::Command&, const std::string&) override {
    return {false, "simulated"};
  }
  operation::CommandResult select(const std::string&, const std::string&) override {
    return {false, "simulated"};
  }
  operation::CommandResult open_stream(const std::string&, const std::string&,
                                       std::unique_ptr<program::Source>, std::uint64_t) override {
    return {false, "simulated"};
  }
  void request_answered(const std::string&, const operation::CommandResult&) override {}
  void link_up(const link::ServerSettings&) override {}
  void link_lost(const std::string&) override {}

 private:
  link::Spool spool_;
  link::ProgramMemory memory_;
  std::unique_ptr<link::Link> link_;
  operation::Live live_;
  double phase_ = 0;
  std::uint64_t parts_ = 0;
};

}  // namespace

int main(int count, char** arguments) {
  headstock::options::Program app("Many simulated agents against one server");
  std::string server = "127.0.0.1:7878", tokens_file, folder_name;
  double updates = 5, parts_per_minute = 2, seconds = 0;
  app.option("--server", server, "HOST:PORT of the server's agents' port");
  app.option("--tokens", tokens_file, "file with one enrolment token a line").required().existing_file();
  app.option("--updates-per-second", updates).between(0.1, 10.0);
  app.option("--parts-per-minute", parts_per_minute, "of each machine").between(0.0, 600.0);
  app.option("--folder", folder_name, "keeps certificates and spools; a temporary one otherwise");
  app.option("--seconds", seconds, "0: until interrupted");
  if (const auto ended = app.parse(count, arguments, 1)) return *ended;
  headstock::log::leave_out_below("error");

  std::vector<std::string> tokens;
  std::ifstream file(tokens_file);
  for (std::string line; std::getline(file, line);)
    if (!line.empty()) tokens.push_back(line);
  const auto colon = server.rfind(':');
  if (colon == std::string::npos || tokens.empty()) {
    std::fprintf(stderr, "fleet_simulator: --server HOST:PORT and at least one token are needed\n");
    return 1;
  }

  const testing_support::TemporaryFolder temporary;
  const fs::path folder = folder_name.empty() ? temporary.path() : fs::path(folder_name);
  asio::io_context io(1);
  std::vector<std::unique_ptr<SimulatedMachine>> machines;
  for (unsigned number = 0; number < tokens.size(); ++number) {
    const fs::path own = folder / std::to_string(number);
    fs::create_directories(own);
    machines.push_back(std::make_unique<SimulatedMachine>(own, number));
    link::LinkOptions options;
    options.host = server.substr(0, colon);
    options.port = static_cast<std::uint16_t>(std::stoul(server.substr(colon + 1)));
    options.pki_folder = own / "pki";
    options.enrolment_token = tokens[number];
    options.software = "fleet-simulator";
    options.machine_name = "simulated " + std::to_string(number + 1);
    options.profile = "fanuc-0i-t";
    options.axes = {"X", "Z"};
    options.live_interval = milliseconds(static_cast<long>(1000 / updates));
    options.trail_interval = options.live_interval / 4;
    machines.back()->connect(io, options);
  }

  // Parts one after the other over all machines, evenly in time.
  asio::steady_timer part_timer(io);
  std::size_t next = 0;
  const std::chrono::duration<double> between(
      parts_per_minute > 0 ? 60 / parts_per_minute / static_cast<double>(machines.size()) : 1e9);
  std::function<void()> schedule = [&] {
    part_timer.expires_after(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::min(between, std::chrono::duration<double>(3600))));
    part_timer.async_wait([&](const boost::system::error_code& error) {
      if (error) return;
      if (parts_per_minute > 0) machines[next++ % machines.size()]->count_part();
      schedule();
    });
  };
  schedule();

  asio::steady_timer show_timer(io);
  std::function<void()> show = [&] {
    show_timer.expires_after(std::chrono::seconds(5));
    show_timer.async_wait([&](const boost::system::error_code& error) {
      if (error) return;
      std::size_t connected = 0;
      std::uint64_t pending = 0, parts = 0;
      for (const auto& machine : machines) {
        connected += machine->connected();
        pending += machine->pending();
        parts += machine->parts();
      }
      std::printf("{\"agents\":%zu,\"connected\":%zu,\"parts\":%llu,\"pending\":%llu}\n", machines.size(),
                  connected, static_cast<unsigned long long>(parts),
                  static_cast<unsigned long long>(pending));
      std::fflush(stdout);
      show();
    });
  };
  show();

  asio::signal_set signals(io, SIGINT, SIGTERM);
  signals.async_wait([&](const boost::system::error_code& error, int) {
    if (!error) io.stop();
  });
  asio::steady_timer end(io);
  if (seconds > 0) {
    end.expires_after(milliseconds(static_cast<long>(seconds * 1000)));
    end.async_wait([&](const boost::system::error_code&) { io.stop(); });
  }
  io.run();
  return 0;
}
