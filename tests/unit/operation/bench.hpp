// A controller on the bench: programs from text, virtual time, buttons, and a store that commits when it is
// told to.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "operation/controller.hpp"
#include "operation/virtual_time.hpp"

namespace headstock::operation {

class TextPrograms final : public program::Programs {
 public:
  std::map<std::string, std::string, std::less<>> texts;
  std::unique_ptr<program::Source> open_number(std::uint32_t number) override {
    return open_name("O" + std::to_string(number));
  }
  std::unique_ptr<program::Source> open_name(std::string_view name) override {
    const auto found = texts.find(name);
    return found == texts.end() ? nullptr : program::source_from_text(found->second);
  }
};

/// Bytes that come when the test wants them to.
struct Feeder {
  std::string text;
  std::size_t released = 0;
  bool closed = false;
  bool broken = false;  ///< the line failed behind what was released
};
class FedSource final : public program::Source {
 public:
  explicit FedSource(std::shared_ptr<Feeder> feeder) : feeder_(std::move(feeder)) {}
  program::ReadResult read(std::span<char> buffer) override {
    const std::size_t ready = std::min(feeder_->released, feeder_->text.size()) - at_;
    if (ready == 0 && feeder_->broken) return {program::ReadStatus::failed, 0};
    if (ready == 0)
      return {feeder_->closed && at_ == feeder_->text.size() ? program::ReadStatus::end
                                                             : program::ReadStatus::wait,
              0};
    const std::size_t bytes = std::min(ready, buffer.size());
    feeder_->text.copy(buffer.data(), bytes, at_);
    at_ += bytes;
    return {program::ReadStatus::data, bytes};
  }
  bool seek(std::uint64_t) override { return false; }

 private:
  std::shared_ptr<Feeder> feeder_;
  std::size_t at_ = 0;
};

class Bench {
 public:
  explicit Bench(const std::string& profile = "fanuc-0i-m", ControllerOptions options = virtual_options())
      : Bench(*machine::default_machine(profile), std::move(options)) {}
  explicit Bench(machine::Machine machine, ControllerOptions options = virtual_options())
      : controller(std::move(machine), {}, std::move(options)) {}

  void load(const std::string& text, const std::string& name = "O1") {
    programs->texts[name] = text;
    ASSERT_SELECTED(controller.select(name, "hash-" + name, programs));
  }
  CommandResult press(Action action, double value = 0, Origin origin = Origin::panel) {
    return controller.command({action, origin, value});
  }
  bool start() { return press(Action::cycle_start).accepted; }
  State state() const { return controller.live().state; }

  void period() {
    if (committing) commit();
    while (controller.work()) {
    }
    controller.step();
    ++periods;
  }
  void commit() {
    TimedEvent event;
    while (controller.take_event(event)) {
      events.push_back(event);
      ++taken;
    }
    controller.committed(taken);
  }
  /// @return false when it did not come about within `seconds` of machine time.
  template <typename Condition>
  bool until(Condition condition, double seconds = 600) {
    const auto most = static_cast<std::uint64_t>(seconds * 1e6 / controller.machine().period_us);
    for (std::uint64_t i = 0; i < most; ++i) {
      if (condition()) return true;
      period();
    }
    return condition();
  }
  bool until_state(State wanted, double seconds = 600) {
    return until([&] { return state() == wanted; }, seconds);
  }
  template <typename T>
  std::vector<T> all() const {
    std::vector<T> found;
    for (const TimedEvent& event : events)
      if (const T* is = std::get_if<T>(&event.event)) found.push_back(*is);
    return found;
  }

  std::shared_ptr<TextPrograms> programs = std::make_shared<TextPrograms>();
  Controller controller;
  std::vector<TimedEvent> events;
  std::uint64_t taken = 0, periods = 0;
  bool committing = true;

 private:
  static void ASSERT_SELECTED(const CommandResult& result) {
    if (!result.accepted) throw std::runtime_error("select refused: " + result.reason);
  }
};

}  // namespace headstock::operation
