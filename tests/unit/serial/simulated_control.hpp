// The far end of a line: a control with a small buffer that reads unevenly and stops its sender with DC3. A
// thread of its own on a real file descriptor (the other side of a pseudo-terminal, or a socket).
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <random>
#include <string>
#include <thread>

namespace headstock::serial {

class SimulatedControl {
 public:
  struct Behaviour {
    unsigned seed = 1;
    bool start_with_dc1 = true;
    bool stops = true;
    std::size_t hang_up_after = 0;  ///< closes its end after so many characters; 0: never
    bool never_starts = false;
    bool dies_stopped = false;  ///< sends one DC3 and no DC1 any more
    double baud = 0;  ///< reads no faster than this line (10 bits a character); 0: as fast as it comes
  };

  /// A pseudo-terminal; the sender opens device().
  SimulatedControl();
  /// A listening socket on 127.0.0.1; the sender connects to port().
  struct Tcp {};
  explicit SimulatedControl(Tcp);
  ~SimulatedControl();

  const std::string& device() const { return device_; }
  std::uint16_t port() const { return port_; }

  /// Begins to behave: sends DC1 when told, then reads `expected` characters.
  void begin(const Behaviour& behaviour, std::size_t expected);
  /// What it has read once all is there, or the time is over.
  std::string read_all();
  unsigned most_after_stop() const { return most_after_stop_; }
  unsigned stops() const { return stops_; }
  /// Characters a second between the first and the last one.
  double characters_s() const { return characters_s_; }
  /// Sends bytes to the other side as they are.
  void send(const std::string& bytes);
  /// Sends back what comes (a loop-back plug), for ever.
  void echo();
  void hang_up();

 private:
  void run();
  bool take();
  void tell(char code);

  int fd_ = -1, listener_ = -1;
  std::string device_;
  std::uint16_t port_ = 0;
  std::mutex mutex_;
  std::condition_variable done_, accepted_;
  Behaviour behaviour_;
  std::mt19937 random_;
  std::string read_;
  std::size_t expected_ = 0;
  bool active_ = false, stopped_ = false, echo_ = false;
  unsigned buffered_ = 0, after_ = 0;
  std::atomic<unsigned> most_after_stop_{0}, stops_{0};
  std::atomic<double> characters_s_{0};
  std::atomic<bool> end_{false};
  std::chrono::steady_clock::time_point first_{}, next_{};
  std::thread thread_;
};

}  // namespace headstock::serial
