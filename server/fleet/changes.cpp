#include "server/fleet/changes.hpp"

#include <nlohmann/json.hpp>

namespace headstock::fleet {
namespace {

constexpr std::size_t kMostPieces = 1'024;

}  // namespace

Changes::~Changes() {
  for (Subscription* subscription : subscriptions_) subscription->hub_ = nullptr;
}

std::unique_ptr<Changes::Subscription> Changes::subscribe(std::function<void()> wake) {
  auto subscription = std::make_unique<Subscription>();
  subscription->hub_ = this;
  subscription->wake_ = std::move(wake);
  subscriptions_.insert(subscription.get());
  return subscription;
}

Changes::Subscription::~Subscription() {
  if (hub_ != nullptr) hub_->subscriptions_.erase(this);
}

std::vector<Change> Changes::Subscription::take() {
  std::vector<Change> all;
  if (overflown_) all.push_back({"resync", 0, nullptr});
  overflown_ = false;
  for (Change& piece : pieces_) all.push_back(std::move(piece));
  for (auto& [machine, live] : live_) all.push_back({"live", machine, std::move(live)});
  pieces_.clear();
  live_.clear();
  return all;
}

void Changes::publish_live(std::int64_t machine, SharedJson live) {
  for (Subscription* subscription : subscriptions_) {
    const bool wake = !subscription->pending();
    subscription->live_[machine] = live;
    if (wake && subscription->wake_) subscription->wake_();
  }
}

void Changes::publish(Change change) {
  for (Subscription* subscription : subscriptions_) {
    const bool wake = !subscription->pending();
    if (subscription->pieces_.size() == kMostPieces) {
      subscription->pieces_.pop_front();
      subscription->overflown_ = true;
    }
    subscription->pieces_.push_back(change);
    if (wake && subscription->wake_) subscription->wake_();
  }
}

}  // namespace headstock::fleet
