#include "tests/bench/openssl_pair.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

namespace headstock::bench {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kPatience = std::chrono::seconds(60);

/// A program with pipes to its standard input and from its standard output.
class Program {
 public:
  explicit Program(std::vector<std::string> words) {
    int in[2], out[2];
    if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0) return;
    process_ = ::fork();
    if (process_ == 0) {
      ::dup2(in[0], 0);
      ::dup2(out[1], 1);
      const int nowhere = ::open("/dev/null", O_WRONLY);
      ::dup2(nowhere, 2);
      std::vector<char*> arguments;
      for (std::string& word : words) arguments.push_back(word.data());
      arguments.push_back(nullptr);
      ::execvp(arguments[0], arguments.data());
      ::_exit(127);
    }
    ::close(in[0]);
    ::close(out[1]);
    input_ = in[1];
    output_ = out[0];
  }
  ~Program() {
    end();
    ::close(input_);
    ::close(output_);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void end() {
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  int exit_status() {
    int status = -1;
    if (process_ > 0) ::waitpid(process_, &status, 0);
    process_ = -1;
    return status;
  }
  bool write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t count = ::write(input_, bytes.data(), bytes.size());
      if (count <= 0) return false;
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
    return true;
  }
  /// @return bytes read; 0 at the end or when nothing came within the time.
  std::size_t read(std::string& into, std::chrono::milliseconds within) {
    pollfd ready{output_, POLLIN, 0};
    if (::poll(&ready, 1, static_cast<int>(within.count())) != 1) return 0;
    const ssize_t count = ::read(output_, into.data(), into.size());
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

 private:
  pid_t process_ = -1;
  int input_ = -1, output_ = -1;
};

int free_port() {
  const int probe = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  int port = 0;
  if (::bind(probe, reinterpret_cast<sockaddr*>(&address), size) == 0 &&
      ::getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size) == 0)
    port = ntohs(address.sin_port);
  ::close(probe);
  return port;
}

/// Looked up, not tried: a socket of our own on the port could be in the server's way.
bool listening(int port) {
  char wanted[32];
  std::snprintf(wanted, sizeof wanted, ":%04X 00000000:0000 0A", static_cast<unsigned>(port));
  std::ifstream sockets("/proc/net/tcp");
  const std::string all{std::istreambuf_iterator<char>(sockets), {}};
  return all.find(wanted) != std::string::npos;
}

}  // namespace

double openssl_pair_mb_s(const std::filesystem::path& folder, std::uint64_t bytes) {
  const std::string key = folder / "pair-key.pem", certificate = folder / "pair-certificate.pem";
  if (!std::filesystem::exists(certificate)) {
    Program make({"openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
                  "-keyout", key, "-out", certificate, "-days", "2", "-subj", "/CN=localhost"});
    if (make.exit_status() != 0) return 0;
  }
  const int port = free_port();
  const std::string where = "127.0.0.1:" + std::to_string(port);
  Program server(
      {"openssl", "s_server", "-accept", where, "-key", key, "-cert", certificate, "-quiet", "-tls1_3"});
  const auto limit = Clock::now() + kPatience;
  while (!listening(port) && Clock::now() < limit) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  Program client({"openssl", "s_client", "-connect", where, "-quiet", "-tls1_3"});
  // The first byte through means that the handshake is over. It is the client's: s_server may block for good
  // in its read of the handshake's end when it has something to send before.
  std::string buffer(64 << 10, '\0');
  if (!client.write("%") || server.read(buffer, kPatience) != 1) return 0;

  const auto start = Clock::now();
  std::thread writing([&] {
    const std::string piece(64 << 10, 'G');
    for (std::uint64_t sent = 0; sent < bytes; sent += piece.size())
      if (!server.write(piece)) return;
  });
  std::uint64_t received = 0;
  while (received < bytes) {
    const std::size_t got = client.read(buffer, kPatience);
    if (got == 0) break;
    received += got;
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  server.end();
  writing.join();
  return received >= bytes ? static_cast<double>(bytes) / 1e6 / seconds : 0;
}

}  // namespace headstock::bench
