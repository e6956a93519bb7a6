#include <fmt/format.h>
#include <fmt/os.h>

#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "motion/geometry.hpp"
#include "motion/lead_error.hpp"
#include "motion/limits_check.hpp"
#include "motion/path_error.hpp"
#include "offline/simulate.hpp"
#include "offline/session.hpp"
#include "operation/path_length.hpp"
#include "operation/virtual_time.hpp"
#include "protocol/process/options.hpp"

namespace headstock::offline {
namespace {

using machine::AxisVector;

struct SimulateOptions {
  Options controller;
  std::string file, trace;
  int period_us = 0;  // 0: as the machine says
  bool quick = false;
};

constexpr const char* kEndings[] = {"completed", "alarm", "stopped", "stuck", "out_of_budget", "refused"};

// Everything measured while the program runs.
class Measurement {
 public:
  Measurement(operation::Controller& controller, const AxisVector& start, bool judge)
      : controller_(controller),
        axes_(controller.machine().axes.size()),
        period_s_(controller.machine().period_us * 1e-6),
        judge_(judge),
        limits_(axes_, period_s_),
        error_(axes_, motion::tolerance_weights(controller.machine())),
        lead_(axes_),
        last_(start) {
    limits_.add(start);
    error_.start(start);
    lead_.start(start);
  }

  void open_trace(const std::string& file) {
    trace_.emplace(fmt::output_file(file));
    std::string header = "t,line";
    for (const machine::Axis& axis : controller_.machine().axes) (header += ',') += axis.name;
    trace_->print("{},S\n", header);
  }

  void operation(const interp::Operation& operation) {
    const auto& at =
        std::visit([](const auto& o) -> const interp::SourcePosition& { return o.at; }, operation);
    if (at.line != block_.line || at.program != block_.program || at.byte_offset != block_.byte_offset)
      ++blocks;
    block_ = at;
  }
  void move(const motion::Move& move) {
    length_mm += operation::path_length(last_, move);
    last_ = operation::end_of(move);
    if (judge_) error_.add(move);
    if (judge_) lead_.add(move);
  }
  void period() {
    const motion::Sample& sample = controller_.sample();
    if (sample.moving) ++(controller_.cutting() ? cutting : rapid);
    ++periods;
    if (judge_) {
      limits_.add(sample.position);
      if (sample.moving) error_.judge(sample.position, sample.tag);
      lead_.sample(sample, controller_.spindle().phase_rad());
    }
    if (trace_) write_row(sample);
  }
  void close() {
    if (trace_) trace_->close();
  }

  nlohmann::json axes() const {
    nlohmann::json all = nlohmann::json::object();
    for (std::size_t i = 0; i < axes_; ++i) {
      all[std::string(1, controller_.machine().axes[i].name)] = {{"max_v", limits_.max_velocity()[i]},
                                                                 {"max_a", limits_.max_acceleration()[i]},
                                                                 {"max_j", limits_.max_jerk()[i]}};
    }
    return all;
  }
  double max_error_mm() const { return error_.max(); }
  bool cut_threads() const { return lead_.threads() > 0; }
  nlohmann::json threads() const {
    return {{"count", lead_.threads()},
            {"turns", lead_.turns()},
            {"max_pitch_error_mm", lead_.max_mm()},
            {"run_in_mm", lead_.run_in_mm()}};
  }

  std::uint64_t blocks = 0, cutting = 0, rapid = 0, periods = 0;
  double length_mm = 0;

 private:
  void write_row(const motion::Sample& sample) {
    row_.clear();
    auto out = std::back_inserter(row_);
    fmt::format_to(out, "{:.6f},{}", static_cast<double>(periods) * period_s_,
                   controller_.traced_block().line);
    for (std::size_t i = 0; i < axes_; ++i) fmt::format_to(out, ",{:.9f}", sample.position[i]);
    fmt::format_to(out, ",{:.3f}", controller_.spindle_rpm());
    trace_->print("{}\n", row_);
  }

  operation::Controller& controller_;
  const std::size_t axes_;
  const double period_s_;
  const bool judge_;
  motion::LimitsCheck limits_;
  motion::PathError error_;
  motion::LeadError lead_;
  AxisVector last_;
  interp::SourcePosition block_;
  std::optional<fmt::ostream> trace_;
  std::string row_;
};

nlohmann::json alarms_of(const std::vector<operation::TimedEvent>& events) {
  nlohmann::json alarms = nlohmann::json::array();
  for (const operation::TimedEvent& event : events) {
    const auto* raised = std::get_if<operation::AlarmRaised>(&event.event);
    if (!raised) continue;
    const operation::ActiveAlarm& alarm = raised->alarm;
    alarms.push_back({{"code", alarm.code},
                      {"text", {{"en", alarm.text_en}, {"zh", alarm.text_zh}}},
                      {"line", alarm.at.line},
                      {"column", alarm.at.column},
                      {"block", raised->block}});
  }
  return alarms;
}

int fail(const std::string& message) {
  std::cerr << "headstock simulate: " << message << '\n';
  return 1;
}

int simulate(const SimulateOptions& options) {
  std::string error;
  const auto session = make_session(options.controller, error);
  if (!session) return fail(error);
  if (options.period_us != 0) session->machine.period_us = options.period_us;
  if (options.file != "-") {
    if (!open_program(options.file)) return fail(options.file + ": cannot be read");
    session->programs.add_file(options.file);
  }

  operation::ControllerOptions made = operation::virtual_options(session->switches);
  made.drive = axes::make_drive(session->machine);  // exact stops last until the machine's own drives are there
  operation::Controller controller(session->machine, session->data, std::move(made));
  Measurement measurement(controller, session->start_position(), !options.quick);
  try {
    if (!options.trace.empty()) measurement.open_trace(options.trace);
  } catch (const std::system_error& failure) {
    return fail(options.trace + ": " + failure.code().message());
  }
  controller.on_operation([&](const interp::Operation& operation) { measurement.operation(operation); });
  controller.on_move([&](const motion::Move& move) { measurement.move(move); });

  const std::shared_ptr<program::Programs> others(std::shared_ptr<void>(), &session->programs);
  const auto programs = operation::single_program([&] { return open_program(options.file); }, others);
  const operation::CommandResult selected = options.file == "-"
                                                ? controller.select_stream("main", {}, open_program("-"), 0)
                                                : controller.select("main", {}, programs);
  if (!selected.accepted) return fail("refused: " + selected.reason);

  operation::VirtualRun run(controller);
  operation::PeriodCost cost;
  run.cost = &cost;
  const auto begin = std::chrono::steady_clock::now();
  const operation::RunEnd end = run.run([&] {
    measurement.period();
    return true;
  });
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  measurement.close();

  const double period_s = session->machine.period_us * 1e-6;
  const double time_s = static_cast<double>(measurement.periods) * period_s;
  nlohmann::json result = {
      {"time_s", time_s},
      {"cutting_s", static_cast<double>(measurement.cutting) * period_s},
      {"rapid_s", static_cast<double>(measurement.rapid) * period_s},
      {"blocks", measurement.blocks},
      {"length_mm", measurement.length_mm},
      {"axes", measurement.axes()},
      {"max_path_error_mm", measurement.max_error_mm()},
      {"realtime_factor", wall_s > 0 ? time_s / wall_s : 0},
      {"period_cost_us",
       {{"p50", cost.percentile_us(0.5)},
        {"p99", cost.percentile_us(0.99)},
        {"p999", cost.percentile_us(0.999)},
        {"max", cost.percentile_us(1)}}},
      {"end", kEndings[static_cast<std::size_t>(end)]},
      {"parts", controller.retained().parts},
      {"alarms", alarms_of(run.events)},
  };
  if (measurement.cut_threads()) result["threads"] = measurement.threads();
  std::cout << result.dump() << std::endl;
  if (end == operation::RunEnd::stuck)
    return fail("nothing moves any more: is feed per revolution programmed with the spindle standing?");
  if (end == operation::RunEnd::refused) return fail("refused: " + run.reason);
  return end == operation::RunEnd::alarm ? 2 : 0;
}

}  // namespace

void add_simulate(options::Command app, int& exit_status) {
  const auto options = std::make_shared<SimulateOptions>();
  auto command = app.add_command(
      "simulate", "Run a program on the controller in virtual time: time, limits kept, path error");
  add_options(command, options->controller);
  command.option("--period-us", options->period_us, "Interpolation period instead of the machine's")
      .between(250, 8'000);
  command.option("--trace", options->trace, "CSV of every period: t,line,axes,S");
  command.flag("--quick", options->quick, "Leave out the checks of limits and path error");
  command.option("file", options->file, "Program, or - for stdin").required();
  command.callback([options, &exit_status] { exit_status = simulate(*options); });
}

}  // namespace headstock::offline
