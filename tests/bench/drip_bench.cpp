// Throughput of a drip-feed over loopback, from a stored program to the interpreter's thread, and of raw
// TLS 1.3 with the same library, certificates and cipher as the reference. Prints one JSON line.
//
//   bench_drip [MiB, default 256]
#include <openssl/ssl.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "protocol/wire/tls.hpp"
#include "tests/unit/link/shop.hpp"

namespace {

using namespace headstock;
using namespace headstock::testing_support;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A program as long as wanted without being kept in memory: one piece over and over.
class RepeatedText final : public server::BlobReader {
 public:
  RepeatedText(std::string piece, std::uint64_t size) : piece_(std::move(piece)), size_(size) {}
  std::uint64_t size() const override { return size_; }
  std::size_t read(std::uint64_t offset, char* into, std::size_t at_most) override {
    const auto at = static_cast<std::size_t>(offset % piece_.size());
    const std::size_t count =
        std::min<std::size_t>({at_most, piece_.size() - at, static_cast<std::size_t>(size_ - offset)});
    piece_.copy(into, count, at);
    return count;
  }

 private:
  std::string piece_;
  std::uint64_t size_;
};

/// MB/s of SSL_write to SSL_read over a pair of sockets, one thread each.
double raw_tls(const std::filesystem::path& pki, std::uint64_t bytes) {
  const wire::Authority authority(pki, {});
  auto server_context = wire::server_context(authority);
  const auto made = wire::make_key_and_request("agent");
  auto client_context =
      wire::agent_context(authority.ca_pem(), authority.sign(made.request_pem, 1).pem, made.key_pem);
  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) return 0;
  SSL* sender = SSL_new(server_context.native_handle());
  SSL* receiver = SSL_new(client_context.native_handle());
  SSL_set_fd(sender, ends[0]);
  SSL_set_fd(receiver, ends[1]);
  std::thread writing([&] {
    if (SSL_accept(sender) != 1) return;
    const std::string piece(16 << 10, 'G');
    for (std::uint64_t sent = 0; sent < bytes; sent += piece.size())
      if (SSL_write(sender, piece.data(), static_cast<int>(piece.size())) <= 0) return;
  });
  const bool connected = SSL_connect(receiver) == 1;
  const auto start = Clock::now();
  std::string buffer(64 << 10, '\0');
  std::uint64_t received = 0;
  while (connected && received < bytes) {
    const int got = SSL_read(receiver, buffer.data(), static_cast<int>(buffer.size()));
    if (got <= 0) break;
    received += static_cast<std::uint64_t>(got);
  }
  const double seconds = seconds_since(start);
  writing.join();
  SSL_free(sender);
  SSL_free(receiver);
  ::close(ends[0]);
  ::close(ends[1]);
  return received >= bytes ? static_cast<double>(bytes) / 1e6 / seconds : 0;
}

double drip(std::uint64_t bytes, bool& identical) {
  Shop shop;
  asio::io_context agent_io;
  Agent agent(shop.folder.path() / "agent");
  auto options = agent.options(shop.gateway->port());
  options.enrolment_token = shop.token_for(1);
  agent.connect(agent_io, options);
  const auto work = asio::make_work_guard(agent_io);
  std::thread agent_thread([&] { agent_io.run(); });
  shop.until([&] { return shop.gateway->is_connected(1); });

  const auto blob = std::make_shared<RepeatedText>(program_text(1 << 20), bytes);
  wire::Sha256 digest;
  std::string piece(1 << 20, '\0');
  for (std::uint64_t at = 0; at < bytes;) {
    const std::size_t got = blob->read(at, piece.data(), piece.size());
    digest.update({piece.data(), got});
    at += got;
  }
  const auto start = Clock::now();
  const auto answer = shop.wait_for(shop.gateway->drip(1, 1, "big.nc", digest.hex(), blob));
  std::atomic<bool> ended = false;
  std::uint64_t received = 0;
  auto status = program::ReadStatus::wait;
  std::thread interpreter([&] {
    std::string buffer(64 << 10, '\0');
    while (answer.accepted) {
      const auto result = agent.machine.stream->read({buffer.data(), buffer.size()});
      status = result.status;
      received += result.bytes;
      if (status == program::ReadStatus::wait)
        std::this_thread::sleep_for(std::chrono::microseconds(50));
      else if (status != program::ReadStatus::data)
        break;
    }
    ended = true;
  });
  while (!ended) shop.run_for(std::chrono::milliseconds(2));
  const double seconds = seconds_since(start);
  interpreter.join();
  identical = received == bytes &&
              status == program::ReadStatus::end;  // `end` comes only after the hash of all was proven
  agent_io.stop();
  agent_thread.join();
  agent.link.reset();
  return static_cast<double>(bytes) / 1e6 / seconds;
}

}  // namespace

int main(int count, char** arguments) {
  spdlog::set_level(spdlog::level::off);
  const std::uint64_t bytes = (count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 256) << 20;
  const TemporaryFolder pki;
  const double reference = raw_tls(pki.path(), bytes);
  bool identical = false;
  const double fed = drip(bytes, identical);
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  std::printf(
      "{\"drip_mb_s\":%.1f,\"raw_tls_mb_s\":%.1f,\"ratio\":%.3f,\"mib\":%llu,\"identical\":%s,\"peak_memory_"
      "mib\":%ld}\n",
      fed, reference, reference > 0 ? fed / reference : 0.0, static_cast<unsigned long long>(bytes >> 20),
      identical ? "true" : "false", usage.ru_maxrss / 1024);
  return identical ? 0 : 1;
}
