#include "server/api/events/hub.hpp"

#include <algorithm>
#include <charconv>

namespace headstock::api {

using nlohmann::json;

namespace {

/// Points of a machine's path kept for one slow client; older ones are dropped.
constexpr std::size_t max_trail = 500;

std::string dump(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

void append_trail(json& trail, const json& live) {
  const auto more = live.find("trail");
  if (more == live.end() || !more->is_array()) return;
  if (!trail.is_array()) trail = json::array();
  for (const auto& point : *more) trail.push_back(point);
  if (trail.size() > max_trail)
    trail.erase(trail.begin(), trail.begin() + static_cast<std::ptrdiff_t>(trail.size() - max_trail));
}

}  // namespace

bool Wishes::read(const std::string& message) {
  const auto parsed = json::parse(message, nullptr, false);
  if (!parsed.is_object()) return false;
  const auto topics = parsed.find("subscribe");
  if (topics == parsed.end() || !topics->is_array()) return false;
  *this = Wishes{};
  for (const auto& topic : *topics) {
    if (!topic.is_string()) continue;
    const auto& name = topic.get_ref<const std::string&>();
    if (name == "floor") floor_ = true;
    if (name == "transfers") transfers_ = true;
    if (name == "programs") programs_ = true;
    std::int64_t id = 0;
    if (name.starts_with("machine:") && machines_.size() < max_machines) {
      const auto [at, error] = std::from_chars(name.data() + 8, name.data() + name.size(), id);
      if (error == std::errc() && at == name.data() + name.size()) machines_.insert(id);
    }
  }
  return true;
}

bool Wishes::wants(const fleet::Change& change) const {
  if (change.topic == "resync") return true;
  if (change.topic == "transfer") return transfers_ || floor_ || machines_.contains(change.machine);
  if (change.topic == "program") return programs_ || floor_ || transfers_;
  return floor_ || machines_.contains(change.machine);
}

bool Outbox::put(const fleet::Change& change, const Wishes& wishes) {
  if (!wishes.wants(change)) return true;
  if (change.topic == "live") {
    if (!change.body) return true;
    auto& waiting = live_[change.machine];
    waiting.with_trail = wishes.machine(change.machine);
    if (waiting.with_trail) append_trail(waiting.trail, *change.body);
    waiting.live = change.body;
    const auto last = sent_.find(change.machine);
    waiting.due = last == sent_.end() ? Clock::time_point{} : last->second + live_interval;
    return true;
  }
  json message = change.body && change.body->is_object() ? *change.body : json::object();
  // `type` names the topic; a body's own `type` would hide it.
  message["type"] = change.topic;
  if (change.machine != 0 && !message.contains("machine")) message["machine"] = change.machine;
  return put(std::make_shared<const std::string>(dump(message)), Kind::needed);
}

bool Outbox::put(Message message, Kind kind) {
  if (kind == Kind::droppable && !queue_.empty()) return true;
  if (bytes_ + message->size() > max_bytes && !queue_.empty()) return false;
  bytes_ += message->size();
  queue_.push_back(std::move(message));
  return true;
}

Message Outbox::take(Clock::time_point now) {
  if (!queue_.empty()) {
    auto message = std::move(queue_.front());
    queue_.pop_front();
    bytes_ -= message->size();
    return message;
  }
  const auto first = std::ranges::min_element(live_, {}, [](const auto& entry) { return entry.second.due; });
  if (first == live_.end() || first->second.due > now) return nullptr;
  const auto machine = first->first;
  json live = *first->second.live;
  if (first->second.with_trail)
    live["trail"] = first->second.trail.is_array() ? first->second.trail : json::array();
  else
    live.erase("trail");   // the floor does not draw paths
  live_.erase(first);
  sent_[machine] = now;
  return std::make_shared<const std::string>(dump({{"type", "live"}, {"machine", machine}, {"live", std::move(live)}}));
}

std::optional<Outbox::Clock::time_point> Outbox::due() const {
  const auto first = std::ranges::min_element(live_, {}, [](const auto& entry) { return entry.second.due; });
  if (first == live_.end()) return std::nullopt;
  return first->second.due;
}

}  // namespace headstock::api
