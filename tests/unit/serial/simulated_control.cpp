#include "simulated_control.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <stdexcept>

namespace headstock::serial {

using namespace std::chrono_literals;

SimulatedControl::SimulatedControl() {
  fd_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0 || ::grantpt(fd_) != 0 || ::unlockpt(fd_) != 0) throw std::runtime_error("no pseudo-terminal");
  device_ = ::ptsname(fd_);
  thread_ = std::thread([this] { run(); });
}

SimulatedControl::SimulatedControl(Tcp) {
  listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), length) != 0 || ::listen(listener_, 1) != 0 ||
      ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length) != 0)
    throw std::runtime_error("no socket");
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { run(); });
}

SimulatedControl::~SimulatedControl() {
  end_ = true;
  thread_.join();
  if (fd_ >= 0) ::close(fd_);
  if (listener_ >= 0) ::close(listener_);
}

void SimulatedControl::begin(const Behaviour& behaviour, std::size_t expected) {
  std::unique_lock lock(mutex_);
  accepted_.wait_for(lock, 20s, [&] { return fd_ >= 0; });
  behaviour_ = behaviour;
  random_.seed(behaviour.seed);
  read_.clear();
  expected_ = expected;
  active_ = true;
  stopped_ = false;
  buffered_ = after_ = 0;
  first_ = next_ = {};
  if (behaviour.start_with_dc1 && !behaviour.never_starts) tell('\x11');
}

std::string SimulatedControl::read_all() {
  std::unique_lock lock(mutex_);
  done_.wait_for(lock, 20s, [&] { return read_.size() >= expected_; });
  active_ = false;
  return read_;
}

void SimulatedControl::send(const std::string& bytes) {
  for (const char byte : bytes) {
    const std::scoped_lock lock(mutex_);
    tell(byte);
  }
}

void SimulatedControl::echo() {
  const std::scoped_lock lock(mutex_);
  echo_ = true;
}

void SimulatedControl::hang_up() {
  const std::scoped_lock lock(mutex_);
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

void SimulatedControl::tell(char code) {
  while (fd_ >= 0 && ::write(fd_, &code, 1) < 0 && errno == EAGAIN) std::this_thread::yield();
}

/// @return whether anything came.
bool SimulatedControl::take() {
  const std::scoped_lock lock(mutex_);
  if (fd_ < 0) {
    if (listener_ >= 0) fd_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (fd_ >= 0) accepted_.notify_all();
    return false;
  }
  if (!active_ && !echo_) return false;
  const auto now = std::chrono::steady_clock::now();
  std::array<char, 64> piece;
  std::size_t most = echo_ ? piece.size() : 1 + random_() % 16;
  if (behaviour_.baud > 0) {
    // Characters that had the time to cross the line since the last look.
    const auto character = std::chrono::nanoseconds(static_cast<std::int64_t>(10e9 / behaviour_.baud));
    if (next_ == std::chrono::steady_clock::time_point{}) next_ = now;
    most = 0;
    while (most < piece.size() && next_ + character * static_cast<std::int64_t>(most + 1) <= now) ++most;
    if (most == 0) return false;
    const auto count = ::read(fd_, piece.data(), most);
    // A line with nothing on it has lost that time.
    next_ = count == static_cast<ssize_t>(most) ? next_ + character * count : now;
    if (count <= 0) return false;
    if (read_.empty()) first_ = now;
    read_.append(piece.data(), static_cast<std::size_t>(count));
    if (read_.size() > 1)
      characters_s_ =
          static_cast<double>(read_.size() - 1) / std::chrono::duration<double>(now - first_).count();
    if (read_.size() >= expected_) done_.notify_all();
    return true;
  }
  const auto count = ::read(fd_, piece.data(), most);
  if (count <= 0) return false;
  if (echo_) {
    for (ssize_t i = 0; i < count; ++i) tell(piece[static_cast<std::size_t>(i)]);
    return true;
  }
  for (ssize_t i = 0; i < count; ++i) {
    read_ += piece[static_cast<std::size_t>(i)];
    if (stopped_) most_after_stop_ = std::max(most_after_stop_.load(), ++after_);
    ++buffered_;
    if (behaviour_.stops && !stopped_ && (buffered_ > 96 || random_() % 100 == 0)) {
      stopped_ = true;
      after_ = 0;
      ++stops_;
      tell(random_() % 2 ? '\x13' : '\x93');
    }
  }
  if (behaviour_.hang_up_after > 0 && read_.size() >= behaviour_.hang_up_after) {
    ::close(fd_);
    fd_ = -1;
  }
  if (read_.size() >= expected_) done_.notify_all();
  return true;
}

void SimulatedControl::run() {
  while (!end_) {
    const bool came = take();
    auto rest = 50us;
    {
      const std::scoped_lock lock(mutex_);
      buffered_ -= std::min(buffered_, static_cast<unsigned>(random_() % 24));
      if (stopped_ && buffered_ < 32 && !behaviour_.dies_stopped && fd_ >= 0) {
        stopped_ = false;
        tell('\x11');
      }
      if (behaviour_.baud > 0) rest = 20us;
    }
    if (!came) std::this_thread::sleep_for(rest);
  }
}

}  // namespace headstock::serial
