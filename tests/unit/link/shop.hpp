// A server and machines in one process over real TLS sockets, driven by one thread; and a proxy that cuts the
// line.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "link/link.hpp"
#include "link/program_memory.hpp"
#include "link/spool.hpp"
#include "protocol/wire/certificates.hpp"
#include "protocol/wire/digest.hpp"
#include "server/gateway/gateway.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace headstock::testing_support {

namespace asio = boost::asio;
using nlohmann::json;

/// The store behind the gateway: survives the gateway, as a database does.
class FakeFleet final : public server::GatewayHost {
 public:
  explicit FakeFleet(asio::io_context& io) : io_(io) {}

  std::map<std::string, std::int64_t> tokens;
  std::map<std::int64_t, std::string> certificates;
  std::map<std::string, std::uint64_t> last_event;  ///< spool → sequence
  std::vector<json> events_committed;
  std::map<std::int64_t, json> census_of, live_of, hello_of;
  std::map<std::int64_t, int> live_count, connects;
  std::vector<std::string> disconnects;
  std::map<std::uint64_t, server::TransferState> transfers;
  int transfer_reports = 0, waits = 0;
  bool store_broken = false;
  /// The store is busy with a census for as long as this holds.
  bool census_held = false;
  /// What the store was given of a machine, in order: "census", "events 4", "report 3".
  std::map<std::int64_t, std::vector<std::string>> stored;

  asio::awaitable<std::int64_t> redeem_token(std::string secret) override {
    co_await asio::post(io_, asio::use_awaitable);
    const auto found = tokens.find(secret);
    if (found == tokens.end()) co_return 0;
    const std::int64_t machine = found->second;
    tokens.erase(found);
    co_return machine;
  }
  asio::awaitable<void> certificate_issued(std::int64_t machine, std::string serial) override {
    certificates[machine] = serial;
    co_return;
  }
  asio::awaitable<bool> certificate_valid(std::int64_t machine, std::string serial) override {
    co_return certificates.contains(machine) && certificates[machine] == serial;
  }
  asio::awaitable<std::string> machine_name(std::int64_t machine) override {
    co_return "Machine " + std::to_string(machine);
  }
  void connected(std::int64_t machine, const json& hello) override {
    hello_of[machine] = hello;
    ++connects[machine];
  }
  void disconnected(std::int64_t, const std::string& reason) override { disconnects.push_back(reason); }
  void live(std::int64_t machine, json live) override {
    live_of[machine] = std::move(live);
    ++live_count[machine];
  }
  asio::awaitable<std::uint64_t> events(std::int64_t machine, std::string spool, json events) override {
    stored[machine].push_back("events " + events.back()["seq"].dump());
    co_await asio::post(io_, asio::use_awaitable);
    if (store_broken) throw std::runtime_error("disk full");
    auto& last = last_event[spool];
    for (json& event : events) {
      const auto sequence = event["seq"].get<std::uint64_t>();
      if (sequence <= last) continue;
      last = sequence;
      events_committed.push_back(std::move(event));
    }
    co_await asio::post(io_, asio::use_awaitable);
    co_return last;
  }
  asio::awaitable<void> census(std::int64_t machine, json programs) override {
    stored[machine].push_back("census");
    while (census_held) co_await asio::post(io_, asio::use_awaitable);
    census_of[machine] = std::move(programs);
  }
  asio::awaitable<void> data_report(std::int64_t machine, std::string, const json& report) override {
    stored[machine].push_back("report " + report["sequence"].dump());
    co_await asio::post(io_, asio::use_awaitable);
  }
  /// What machines may ask for, and what they asked.
  std::map<std::string, std::string> library;
  std::vector<std::string> asked;
  server::Gateway* gateway = nullptr;
  asio::awaitable<server::MachineAnswer> program_requested(std::int64_t machine, std::string name) override;
  void transfer_changed(const server::TransferState& state) override {
    transfers[state.id] = state;
    ++transfer_reports;
    if (state.state == "waiting") ++waits;
  }

 private:
  asio::io_context& io_;
};

class FakeMachine final : public link::LinkHost {
 public:
  operation::Live now;
  std::vector<std::string> commands;
  operation::CommandResult answer{true, ""};
  std::unique_ptr<program::Source> stream;
  std::uint64_t stream_bytes = 0;
  int ups = 0, losts = 0;
  json report;  ///< what the machine has of data; null: nothing
  int reports = 0;

  FakeMachine() { now.axes = {"X", "Z"}; }
  operation::Live live() override {
    now.absolute[0] += 0.5;
    return now;
  }
  std::string selected_sha256() override { return ""; }
  operation::CommandResult command(const operation::Command& c, const std::string& user) override {
    commands.push_back(std::to_string(static_cast<int>(c.action)) + " " + std::to_string(c.value) + " " +
                       user);
    return answer;
  }
  operation::CommandResult select(const std::string& name, const std::string& user) override {
    commands.push_back("select " + name + " " + user);
    return answer;
  }
  operation::CommandResult open_stream(const std::string&, const std::string&,
                                       std::unique_ptr<program::Source> opened,
                                       std::uint64_t bytes) override {
    if (answer.accepted) {
      stream = std::move(opened);
      stream_bytes = bytes;
    }
    return answer;
  }
  json data_report() override {
    reports += report.is_object();
    return report;
  }
  std::vector<std::string> answers;  ///< to requests at the panel
  void request_answered(const std::string& name, const operation::CommandResult& said) override {
    answers.push_back(name + ' ' + (said.accepted ? "accepted" : said.reason));
  }
  void link_up(const link::ServerSettings&) override { ++ups; }
  void link_lost(const std::string& reason) override {
    ++losts;
    lost_reason = reason;
  }
  std::string lost_reason;
};

/// A stored revision in memory; counts what is read at once.
class TextBlob final : public server::BlobReader {
 public:
  explicit TextBlob(std::shared_ptr<const std::string> text) : text_(std::move(text)) {}
  std::uint64_t size() const override { return text_->size(); }
  std::size_t read(std::uint64_t offset, char* into, std::size_t at_most) override {
    if (offset >= text_->size()) return 0;
    return text_->copy(into, at_most, static_cast<std::size_t>(offset));
  }

 private:
  std::shared_ptr<const std::string> text_;
};

/// Passes bytes on to a port and cuts both sides after as many bytes as it is told.
class CuttingProxy {
 public:
  CuttingProxy(asio::io_context& io, std::uint16_t to);
  ~CuttingProxy();
  std::uint16_t port() const { return acceptor_.local_endpoint().port(); }
  void forward_to(std::uint16_t port) { to_ = port; }
  /// Bytes (both directions) a connection may pass before it is cut; asked at each connection. Empty: for
  /// ever.
  std::function<std::optional<std::size_t>()> allowance;
  /// A stalled proxy takes bytes no more, without closing anything.
  bool stalled = false;
  int cuts = 0, accepted = 0;
  void cut_all();

 private:
  struct Pair;
  asio::awaitable<void> accept_loop();
  static asio::awaitable<void> pump(CuttingProxy* proxy, std::shared_ptr<Pair> pair, bool up,
                                    std::shared_ptr<bool> alive);

  asio::io_context& io_;
  asio::ip::tcp::acceptor acceptor_;
  std::uint16_t to_;
  std::vector<std::weak_ptr<Pair>> pairs_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
};

/// One agent with its folders, which survive the link object as a disk does.
struct Agent {
  Agent(const std::filesystem::path& folder, std::uint64_t memory_bytes = 2u << 20)
      : pki(folder / "pki"), spool(made(folder) / "spool.sqlite"), memory(folder / "programs", memory_bytes) {}
  static const std::filesystem::path& made(const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    return folder;
  }
  std::filesystem::path pki;
  link::Spool spool;
  link::ProgramMemory memory;
  FakeMachine machine;
  std::unique_ptr<link::Link> link;

  link::LinkOptions options(std::uint16_t port) const;
  void connect(asio::io_context& io, link::LinkOptions options);
};

class Shop {
 public:
  Shop();
  ~Shop();
  asio::io_context io;
  TemporaryFolder folder;
  FakeFleet fleet{io};
  std::unique_ptr<server::Gateway> gateway;

  server::GatewayOptions gateway_options() const;
  void start_gateway();
  void stop_gateway();
  std::string token_for(std::int64_t machine);
  /// Runs the loop until the condition holds. @return false after 30 s (300 s under the thread sanitizer).
  bool until(const std::function<bool()>& condition);
  /// Runs the loop for a while, to see that nothing happens.
  void run_for(std::chrono::milliseconds time);
  template <class T>
  T wait_for(asio::awaitable<T> work) {
    std::optional<T> result;
    asio::co_spawn(
        io,
        [&result, task = std::move(work)]() mutable -> asio::awaitable<void> {
          result = co_await std::move(task);
        },
        asio::detached);
    until([&] { return result.has_value(); });
    if (!result) throw std::runtime_error("no answer");
    return std::move(*result);
  }
};

std::string program_text(std::size_t bytes, unsigned seed = 1);

}  // namespace headstock::testing_support
