// Programs that this machine asks the server for: M198 calls one as a sub-program while the machine runs, an
// operator at the panel asks for one to be fed (DNC mode). The server answers, and then opens a drip-feed of
// that name.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "program/source.hpp"

namespace headstock::link {

/// "O1234", "o01234.nc" and "O1234" are the same program; other names are compared as they are.
bool same_program(std::string_view a, std::string_view b);

class ProgramRequests {
 public:
  struct Asked {
    std::uint64_t id = 0;
    std::string name;
  };
  /// @param wake called when there is something to send; any thread.
  explicit ProgramRequests(std::function<void()> wake);
  ~ProgramRequests();

  // ---- any thread
  /// M198. The source waits until the program comes and fails when the server refuses, the link is lost
  /// before it was opened, or nobody answers. @return nullptr when there is no link.
  std::unique_ptr<program::Source> open(const std::string& name);
  /// DNC mode. @return false when there is no link.
  bool ask(const std::string& name);

  // ---- the link's thread
  void link_is_up();
  /// Whoever still waits for an answer gets none.
  void link_is_lost();
  /// What is to be sent now.
  std::vector<Asked> take_unsent();
  /// The server's word. @return the name when it was asked for at the panel and not by M198.
  std::optional<std::string> answered(std::uint64_t id, bool accepted, const std::string& reason);
  /// Is an M198 waiting for this program?
  bool wanted(std::string_view name) const;
  /// Hands over the stream. @return false when nobody waits for it any more.
  bool hand_over(std::string_view name, std::unique_ptr<program::Source> stream);

 private:
  struct Waiting;
  friend class RequestedSource;
  struct Entry {
    std::string name;
    std::shared_ptr<Waiting> waiting;  ///< none: asked for at the panel
    bool sent = false;
  };

  std::function<void()> wake_;
  mutable std::mutex mutex_;
  bool up_ = false;
  std::uint64_t last_ = 0;
  std::map<std::uint64_t, Entry> entries_;
};

}  // namespace headstock::link
