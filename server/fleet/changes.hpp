// What changes in the shop, for everyone who watches (WebSocket, MQTT later). In-process, bounded: of a
// machine's live state a slow watcher gets the newest only; of the rest it gets at most 1,024 pieces and is
// then told to ask anew. Network thread only.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <vector>

namespace headstock::fleet {

using SharedJson = std::shared_ptr<const nlohmann::json>;

struct Change {
  std::string topic;         ///< live alarm part transfer program machine state resync
  std::int64_t machine = 0;  ///< 0: not about one machine
  SharedJson body;  ///< as in server/api/README.md; empty for resync: some pieces were dropped, ask anew
};

class Changes {
 public:
  class Subscription {
   public:
    ~Subscription();
    /// Everything since the last call: pieces in order, then live states by machine.
    std::vector<Change> take();
    bool pending() const { return !pieces_.empty() || !live_.empty(); }

   private:
    friend class Changes;
    Changes* hub_ = nullptr;
    std::function<void()> wake_;
    std::deque<Change> pieces_;
    std::map<std::int64_t, SharedJson> live_;
    bool overflown_ = false;
  };

  ~Changes();
  /// @param wake called when something becomes pending (not again until taken). Must not publish or
  /// unsubscribe.
  std::unique_ptr<Subscription> subscribe(std::function<void()> wake);
  void publish_live(std::int64_t machine, SharedJson live);
  void publish(Change change);
  std::size_t watchers() const { return subscriptions_.size(); }

 private:
  std::set<Subscription*> subscriptions_;
};

}  // namespace headstock::fleet
