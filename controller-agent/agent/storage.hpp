// The storage thread: takes what must not be lost from the controller, commits it to the spool together with the values
// that belong to it, and only then tells the controller to go on.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "link/spool.hpp"
#include "operation/controller.hpp"

namespace headstock::agent {

class Storage {
 public:
  /// Both must outlive the storage. The thread starts here.
  Storage(operation::Controller& controller, link::Spool& spool);
  /// Commits what is still there and stops.
  ~Storage();
  Storage(const Storage&) = delete;
  Storage& operator=(const Storage&) = delete;

 private:
  void run(const std::stop_token& stop);
  /// @return false when there was nothing to take.
  bool commit_some();

  operation::Controller& controller_;
  link::Spool& spool_;
  std::uint64_t committed_ = 0;
  operation::Retained kept_;
  std::mutex mutex_;
  std::condition_variable_any woken_;
  bool something_ = true;  ///< there may be something to take
  std::jthread thread_;
};

}  // namespace headstock::agent
