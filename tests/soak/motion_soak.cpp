// A long run on the agent's clock, judged set-point by set-point against virtual time. See README.md.
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <thread>

#include "agent/machine_clock.hpp"
#include "motion/limits_check.hpp"
#include "operation/virtual_time.hpp"

namespace {

using namespace headstock;
using namespace std::chrono_literals;

constexpr double kPeriod_s = 0.001;

/// What reached the drives: every set-point that differs from the one before, in order.
struct Sum {
  std::atomic<std::uint64_t> points{0}, hash{0};
  std::atomic<bool> outside{false};

  bool operator==(const Sum& other) const { return points == other.points && hash == other.hash; }
  void restart() { points = hash = 0; }
};

class SummingDrive final : public axes::Drive {
 public:
  SummingDrive(const machine::Machine& machine, Sum& sum)
      : machine_(machine), sum_(sum), limits_(machine.axes.size(), kPeriod_s) {
    for (std::size_t i = 0; i < machine.axes.size(); ++i) position_[i] = machine.axes[i].reference_mm;
    limits_.add(position_);  // the first period may already move
  }
  void enable(bool) noexcept override {}
  void command(const axes::AxisVector& position) noexcept override {
    limits_.add(position);
    for (std::size_t i = 0; i < machine_.axes.size(); ++i) {
      const machine::Axis& axis = machine_.axes[i];
      const double speed = std::max(axis.rapid_mm_min, axis.max_feed_mm_min) / 60;
      if (limits_.max_velocity()[i] > 1.001 * speed ||
          limits_.max_acceleration()[i] > 1.01 * axis.max_acceleration_mm_s2 ||
          limits_.max_jerk()[i] > 1.05 * axis.max_jerk_mm_s3)
        sum_.outside = true;
    }
    if (position == position_) return;
    position_ = position;
    std::uint64_t hash = sum_.hash;
    for (const double value : position) {
      std::uint64_t bits;
      std::memcpy(&bits, &value, sizeof bits);
      hash = (hash ^ bits) * 0x100000001b3u + 0x9e3779b97f4a7c15u;
    }
    sum_.hash = hash;
    ++sum_.points;
  }
  axes::AxisVector actual() const noexcept override { return position_; }
  void set_position(const axes::AxisVector& position) noexcept override { position_ = position; }

 private:
  const machine::Machine& machine_;
  Sum& sum_;
  motion::LimitsCheck limits_;
  axes::AxisVector position_{};
};

std::string surface() {
  std::string text = "O1\nG21 G90 G94 G17\nG00 X0. Y0. Z0.\n";
  char block[80];
  for (int pass = 0; pass < 10; ++pass)
    for (int i = 0; i <= 400; ++i) {
      const double x = 0.1 * (pass % 2 ? 400 - i : i), y = 0.5 * pass;
      std::snprintf(block, sizeof block, "G01 X%.3f Y%.3f Z%.4f F6000.\n", x, y,
                    2 * std::sin(0.8 * x) * std::cos(0.5 * y));
      text += block;
    }
  return text + "G00 X0. Y0. Z0.\nM30\n";
}

machine::Machine machine_of_soak() {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  machine.period_us = static_cast<int>(kPeriod_s * 1e6);
  for (machine::Axis& axis : machine.axes) {
    axis.max_feed_mm_min = axis.rapid_mm_min = 30'000;
    axis.max_acceleration_mm_s2 = 2'000;
    axis.max_jerk_mm_s3 = 500'000;
  }
  return machine;
}

std::unique_ptr<operation::Controller> controller_of(const machine::Machine& machine, const std::string& text,
                                                     Sum& sum) {
  operation::ControllerOptions options;
  options.drive = std::make_unique<SummingDrive>(machine, sum);
  auto controller =
      std::make_unique<operation::Controller>(machine, interp::MachineData{}, std::move(options));
  controller->select("main", "soak",
                     operation::single_program([text] { return program::source_from_text(text); }));
  return controller;
}

bool press_start(operation::Controller& controller) {
  return controller.command({operation::Action::cycle_start, operation::Origin::panel, 0}).accepted;
}

}  // namespace

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 600;
  const machine::Machine machine = machine_of_soak();
  const std::string text = surface();
  Sum reference, sum;
  {
    const auto controller = controller_of(machine, text, reference);
    operation::VirtualRun run(*controller);
    if (run.run([] { return true; }) != operation::RunEnd::completed) {
      std::fprintf(stderr, "soak: the run in virtual time did not complete: %s\n", run.reason.c_str());
      return 1;
    }
  }
  const auto controller = controller_of(machine, text, sum);
  std::uint64_t runs = 0, identical = 0, points = 0, taken = 0;
  agent::Lateness lateness;
  bool real_time = false, refused = false;
  {
    agent::MachineClock clock(*controller, agent::Clock::real);
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < end && !refused) {
      sum.restart();
      refused = !press_start(*controller);
      ++runs;
      do {  // the part is on the disk as soon as it is counted
        std::this_thread::sleep_for(5ms);
        operation::TimedEvent event;
        while (controller->take_event(event)) ++taken;
        controller->committed(taken);
      } while (controller->live().state == operation::State::running);
      if (controller->live().state != operation::State::idle) break;
      identical += sum == reference;
      points += sum.points;
    }
    clock.stop();
    lateness = clock.lateness();
    real_time = clock.real_time();
  }
  const bool good = !refused && runs > 0 && identical == runs && !sum.outside && !reference.outside;
  std::printf(
      "{\"runs\": %llu, \"identical\": %llu, \"set_points\": %llu, \"outside_limits\": %s, \"overruns\": "
      "%llu, "
      "\"periods\": %llu, \"real_time_scheduling\": %s, "
      "\"late_us\": {\"p50\": %.0f, \"p99\": %.0f, \"p99.9\": %.0f, \"max\": %.0f}}\n",
      static_cast<unsigned long long>(runs), static_cast<unsigned long long>(identical),
      static_cast<unsigned long long>(points), sum.outside ? "true" : "false",
      static_cast<unsigned long long>(controller->live().overruns),
      static_cast<unsigned long long>(lateness.periods()), real_time ? "true" : "false",
      lateness.percentile_us(0.5), lateness.percentile_us(0.99), lateness.percentile_us(0.999),
      lateness.max_us());
  return good ? 0 : 1;
}
