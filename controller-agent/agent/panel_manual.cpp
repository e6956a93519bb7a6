#include "agent/panel_manual.hpp"

#include <array>
#include <boost/asio/steady_timer.hpp>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

namespace headstock::agent {

using nlohmann::json;
using operation::CommandResult;

struct PanelManual::Impl {
  Impl(boost::asio::io_context& io_context, operation::Controller& target)
      : io(io_context), controller(target) {
    timers.reserve(machine::kMaxAxes);
    for (std::size_t i = 0; i < machine::kMaxAxes; ++i) timers.emplace_back(io);
  }

  std::optional<std::size_t> axis(const json& request) const {
    const std::string name = text(request, "axis");
    return name.size() == 1 ? controller.machine().axis_index(name[0]) : std::nullopt;
  }
  static std::string text(const json& request, const char* key) {
    const auto found = request.find(key);
    return found != request.end() && found->is_string() ? found->get<std::string>() : std::string();
  }
  static std::optional<double> number(const json& request, const char* key) {
    const auto found = request.find(key);
    if (found == request.end() || !found->is_number()) return std::nullopt;
    return found->get<double>();
  }

  CommandResult jog(const json& request) {
    const auto which = axis(request);
    const auto direction = number(request, "direction");
    if (!which || !direction) return {false, "bad_value"};
    const int sense = *direction > 0 ? 1 : *direction < 0 ? -1 : 0;
    if (sense == 0) {
      pressed[*which] = 0;
      timers[*which].cancel();
      return controller.jog(*which, 0);
    }
    if (pressed[*which] != sense) {
      const auto speed = request.value("rapid", json(false)) == json(true)
                             ? operation::Controller::JogSpeed::rapid
                             : operation::Controller::JogSpeed::feed;
      CommandResult result = controller.jog(*which, sense, speed);
      if (!result.accepted) return result;
      pressed[*which] = sense;
    }
    keep_alive(*which);
    return {true, {}};
  }

  void keep_alive(std::size_t which) {
    timers[which].expires_after(kJogAlive);
    timers[which].async_wait([this, which](boost::system::error_code error) {
      if (error) return;
      pressed[which] = 0;
      controller.jog(which, 0);
    });
  }

  CommandResult step(const json& request) {
    const auto which = axis(request);
    const auto distance = number(request, "distance");
    return which && distance ? controller.step_axis(*which, *distance) : CommandResult{false, "bad_value"};
  }

  CommandResult reference(const json& request) {
    const auto which = axis(request);
    return which ? controller.reference_return(*which) : CommandResult{false, "bad_value"};
  }

  CommandResult mdi(const json& request) {
    const std::string block = text(request, "block");
    return block.empty() ? CommandResult{false, "bad_value"} : controller.enter_mdi(block + "\n");
  }

  /// Without a place: where the last run was broken off.
  CommandResult restart(const json& request) {
    const auto whole = [&](const char* key) {
      const auto value = number(request, key);
      return value && *value >= 0 && *value < 4e9 ? static_cast<std::uint32_t>(*value) : 0u;
    };
    if (!request.contains("block") && !request.contains("sequence")) return controller.restart(std::nullopt);
    interp::RestartPoint point;
    point.block = whole("block");
    point.sequence = whole("sequence");
    if (request.contains("occurrence")) point.occurrence = whole("occurrence");
    return controller.restart(point);
  }

  CommandResult interruption(const json& request) {
    controller.set_interruption_signal(number(request, "value").value_or(0) != 0);
    return {true, {}};
  }

  CommandResult retrace(const json& request) {
    const auto way = number(request, "distance");
    return way ? controller.retrace(*way) : CommandResult{false, "bad_value"};
  }

  CommandResult axis_lock(const json& request) {
    std::uint32_t mask = 0;
    for (const char name : text(request, "axes")) {
      const auto which = controller.machine().axis_index(name);
      if (!which) return {false, "bad_value"};
      mask |= 1u << *which;
    }
    return controller.command(
        {operation::Action::set_axis_lock, operation::Origin::panel, static_cast<double>(mask)});
  }

  boost::asio::io_context& io;
  operation::Controller& controller;
  std::vector<boost::asio::steady_timer> timers;
  std::array<int, machine::kMaxAxes> pressed{};
};

PanelManual::PanelManual(boost::asio::io_context& io, operation::Controller& controller)
    : impl_(std::make_unique<Impl>(io, controller)) {}
PanelManual::~PanelManual() = default;

std::optional<CommandResult> PanelManual::carry_out(const std::string& verb, const json& request) {
  struct Verb {
    std::string_view word;
    CommandResult (Impl::*act)(const json&);
  };
  static constexpr Verb verbs[] = {
      {"jog", &Impl::jog}, {"step", &Impl::step},       {"reference", &Impl::reference},
      {"mdi", &Impl::mdi}, {"retrace", &Impl::retrace}, {"axis_lock", &Impl::axis_lock},
      {"restart", &Impl::restart}, {"interruption", &Impl::interruption}};
  for (const Verb& each : verbs)
    if (each.word == verb) return (impl_.get()->*each.act)(request);
  return std::nullopt;
}

}  // namespace headstock::agent
