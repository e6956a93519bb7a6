// A check in earnest: the machine's own interpreter and kernel, in virtual time. Where a program is too long
// to be timed, its language and its end points are still checked to the last block.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "db/refusal.hpp"
#include "dialects/catalogue.hpp"
#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "machine/machine.hpp"
#include "operation/backplot.hpp"
#include "operation/timing.hpp"
#include "program/source.hpp"
#include "server/library/check_setup.hpp"
#include "server/library/checks.hpp"

namespace headstock::library {
namespace {

constexpr std::size_t kMostFindings = 100;

void add(CheckResult& result, std::int64_t line, std::int64_t column, std::string code, std::string en,
         std::string zh) {
  if (result.findings.size() < kMostFindings)
    result.findings.push_back({line, column, std::move(code), std::move(en), std::move(zh)});
}

/// Reads the whole program without moving anything: alarms of the language, and end points outside the
/// stroke.
void dry_run(const CheckJob& job, Setup& setup, CheckResult& result) {
  const dialects::Dialect* dialect = dialects::find(setup.machine.profile);
  if (dialect == nullptr) return;
  interp::Interpreter interpreter(*dialect, setup.machine, setup.data, setup.neighbours.get());
  machine::AxisVector start{};
  for (std::size_t i = 0; i < setup.machine.axes.size(); ++i) start[i] = setup.machine.axes[i].reference_mm;
  interpreter.start(setup.open(), start);
  interp::Operation operation;
  std::int64_t operations = 0;
  while (interpreter.next(operation) == interp::Pull::operation) {
    if (job.cancel != nullptr && (operations & 1023) == 0 && *job.cancel) return;
    if (++operations > job.max_blocks) {
      add(result, 0, 0, "too_long", "The program is too long to be checked.", "程序过长，无法检查。");
      return;
    }
    if (const auto* alarm = std::get_if<interp::Alarm>(&operation)) {
      const auto text = dialects::alarm_text(setup.machine.profile, alarm->code);
      add(result, alarm->at.line, alarm->at.column, alarm->code, std::string(text.en), std::string(text.zh));
      return;
    }
    const auto* motion = std::visit(
        [](const auto& one) -> const interp::Motion* {
          if constexpr (std::is_base_of_v<interp::Motion, std::decay_t<decltype(one)>>) return &one;
          return nullptr;
        },
        operation);
    for (std::size_t i = 0; motion != nullptr && i < setup.machine.axes.size(); ++i) {
      const machine::Axis& axis = setup.machine.axes[i];
      const double end = motion->end_machine[i];
      if (end >= axis.min_mm && end <= axis.max_mm) continue;
      add(result, motion->at.line, 0, "stroke_limit",
          std::string("End point outside the stroke of axis ") + axis.name,
          std::string("终点超出行程，轴 ") + axis.name);
      return;
    }
  }
}

/// Why the run in virtual time ended early. "budget" is none: then the language was checked to the last block
/// instead.
void add_incomplete(const std::string& reason, CheckResult& result) {
  if (reason == "budget") return;
  if (reason == "stuck")
    add(result, 0, 0, "stuck",
        "Feed per revolution while the spindle stands still: the machine would wait for ever.",
        "主轴停止时使用每转进给，机床将一直等待。");
  else
    add(result, 0, 0, "incomplete", "The check did not reach the end: " + reason,
        "检查未能到达程序结尾：" + reason);
}

}  // namespace

std::string checker_version() {
  return "2";  // 2: tells what a run takes of the tools' lives
}

CheckResult run_check(const CheckJob& job) {
  CheckResult result;
  try {
    Setup setup;
    if (const std::string mistake = set_up(job, setup); !mistake.empty()) {
      add(result, 0, 0, "bad_machine_file", "The machine's description cannot be used: " + mistake,
          "机床配置不可用：" + mistake);
      return result;
    }
    operation::EstimateBudget budget;
    budget.max_blocks = static_cast<std::uint64_t>(job.max_blocks);
    budget.max_machine_s = 1e7;
    budget.max_wall = std::chrono::milliseconds(job.max_wall_ms);
    budget.cancel = job.cancel;
    const auto estimate =
        operation::estimate(setup.machine, setup.data, setup.open, setup.neighbours, {}, budget);
    result.time_s = estimate.time_s;
    result.cutting_s = estimate.cutting_s;
    result.length_mm = estimate.length_mm;
    result.blocks = static_cast<std::int64_t>(estimate.blocks);
    result.timed = estimate.complete;
    for (std::size_t i = 0; i < setup.machine.axes.size(); ++i)
      result.bounds.push_back(
          {std::string(1, setup.machine.axes[i].name), estimate.min_mm[i], estimate.max_mm[i]});
    result.tools.assign(estimate.tools.begin(), estimate.tools.end());
    for (const auto& [group, need] : estimate.life_needed) {
      const bool uses = setup.data.tool_life.find(group)->unit == tools::LifeUnit::uses;
      result.life.push_back({group, uses ? "uses" : "seconds", need});
    }
    for (const auto& alarm : estimate.alarms)
      add(result, alarm.at.line, alarm.at.column, alarm.code, alarm.text_en, alarm.text_zh);
    if (!estimate.complete && result.findings.empty()) {
      dry_run(job, setup, result);
      add_incomplete(estimate.incomplete_reason, result);
    }
    result.ok = result.findings.empty();
  } catch (const std::exception& error) {
    add(result, 0, 0, "internal", std::string("The check failed: ") + error.what(),
        std::string("检查失败：") + error.what());
  }
  return result;
}

Backplot run_backplot(const CheckJob& job, std::int64_t max_points) {
  Setup setup;
  if (const std::string mistake = set_up(job, setup); !mistake.empty())
    throw db::Refusal("bad_machine_file", mistake);
  operation::BackplotLimits limits;
  limits.max_points = static_cast<std::size_t>(std::clamp<std::int64_t>(max_points, 2, 2'000'000));
  limits.cancel = job.cancel;
  auto plot = operation::backplot(setup.machine, setup.data, setup.open, setup.neighbours, {}, limits);
  Backplot result;
  result.truncated = plot.truncated;
  for (const char axis : plot.axes) result.axes.emplace_back(1, axis);
  result.start.assign(plot.start.begin(), plot.start.end());
  for (auto& move : plot.moves)
    result.moves.push_back({static_cast<char>(move.kind), move.line,
                            std::vector<double>(move.points.begin(), move.points.end())});
  return result;
}

}  // namespace headstock::library
