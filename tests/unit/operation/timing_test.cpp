#include "operation/timing.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bench.hpp"
#include "operation/backplot.hpp"

namespace headstock::operation {
namespace {

OpenProgram text(const std::string& program) {
  return [program] {
    // The text must outlive the source.
    class Owner final : public program::Source {
     public:
      explicit Owner(std::string text) : text_(std::move(text)), source_(program::source_from_text(text_)) {}
      program::ReadResult read(std::span<char> buffer) override { return source_->read(buffer); }
      bool seek(std::uint64_t offset) override { return source_->seek(offset); }

     private:
      std::string text_;
      std::unique_ptr<program::Source> source_;
    };
    return std::make_unique<Owner>(program);
  };
}

TEST(Estimate, TimeLengthBoundsAndTools) {
  const auto machine = *machine::default_machine("fanuc-0i-m");
  const RunEstimate estimate = operation::estimate(
      machine, {},
      text("O1\nT3 M06\nG90 G94 G21\nG09 G01 X100. F600.\nG09 G01 Y-50.\nT5 M06\nG00 X0. Y0.\nM30\n"),
      nullptr);
  EXPECT_TRUE(estimate.complete) << estimate.incomplete_reason;
  EXPECT_TRUE(estimate.counts_part);
  EXPECT_TRUE(estimate.alarms.empty());
  EXPECT_NEAR(estimate.cutting_s, 15, 0.5);
  EXPECT_GT(estimate.time_s, estimate.cutting_s + estimate.rapid_s);
  EXPECT_NEAR(estimate.cutting_length_mm, 150, 1e-6);
  // G00 is not interpolated: both axes at once until Y brakes, then X alone. Longer than straight, shorter than in two legs.
  EXPECT_GT(estimate.length_mm, 150 + std::hypot(50, 100) + 1);
  EXPECT_LT(estimate.length_mm, 150 + std::hypot(50, 50) + 50);
  EXPECT_NEAR(estimate.max_mm[0], 100, 1e-3);
  EXPECT_NEAR(estimate.min_mm[1], -50, 1e-3);
  EXPECT_EQ(estimate.tools, (std::vector<std::int32_t>{3, 5}));
}

// The same code on the machine, with its servo drives: the prediction is what it takes, to the period.
TEST(Estimate, IsWhatTheMachineTakes) {
  for (const char* profile : {"fanuc-0i-m", "fanuc-0i-t"}) {
    const bool mill = std::string_view(profile) == "fanuc-0i-m";
    const std::string program = mill ? "O1\nG90 G94 G21 G17\nM03 S1000\nG00 X20. Z5.\nG01 Z-2. F600.\nG61 "
                                       "X40.\nY20.\nG64 G03 X30. Y30. R10.\n"
                                       "G01 X0\nM08\nG04 P250\nG00 Z50.\nM30\n"
                                     : "O1\nG98 G21\nM03 S800\nG00 X40. Z2.\nG01 Z-20. F300.\nG99 G01 X50. "
                                       "F0.2\nG00 Z10.\nG92 X39. Z-15. F1.5\nM30\n";
    ControllerOptions options;  // none given: the drives of the machine file
    options.now_ms = [] { return std::int64_t{0}; };
    Bench bench(profile, std::move(options));
    bench.load(program);
    ASSERT_TRUE(bench.start());
    ASSERT_TRUE(bench.until_state(State::idle, 600)) << profile;
    const double taken_s = static_cast<double>(bench.periods) * bench.controller.machine().period_us * 1e-6;
    const RunEstimate predicted = operation::estimate(bench.controller.machine(), {}, text(program), nullptr);
    EXPECT_TRUE(predicted.complete) << profile;
    EXPECT_NEAR(predicted.time_s, taken_s, 0.003) << profile;
  }
}

TEST(Estimate, SaysWhichAlarmWouldStopIt) {
  auto machine = *machine::default_machine("fanuc-0i-m");
  machine.axes[0].max_mm = 50;
  const RunEstimate estimate =
      operation::estimate(machine, {}, text("O1\nG90 G94 G21\nG01 X100. F6000.\nM30\n"), nullptr);
  EXPECT_TRUE(estimate.complete);
  ASSERT_EQ(estimate.alarms.size(), 1u);
  EXPECT_EQ(estimate.alarms[0].code, "OT0500");
  EXPECT_EQ(estimate.alarms[0].at.line, 3u);
  EXPECT_FALSE(estimate.counts_part);
}

TEST(Estimate, IsBounded) {
  const auto machine = *machine::default_machine("fanuc-0i-m");
  EstimateBudget budget;
  budget.max_machine_s = 100;
  const RunEstimate long_run =
      operation::estimate(machine, {}, text("O1\nG04 X99999.\nM30\n"), nullptr, {}, budget);
  EXPECT_FALSE(long_run.complete);
  EXPECT_EQ(long_run.incomplete_reason, "budget");
  EXPECT_LT(long_run.time_s, 101);

  std::atomic<bool> cancel{true};
  budget.cancel = &cancel;
  const RunEstimate cancelled =
      operation::estimate(machine, {}, text("O1\nG04 X99999.\nM30\n"), nullptr, {}, budget);
  EXPECT_EQ(cancelled.incomplete_reason, "cancelled");

  const RunEstimate stuck =
      operation::estimate(machine, {}, text("O1\nG90 G95 G21\nG01 X100. F0.2\nM30\n"), nullptr);
  EXPECT_EQ(stuck.incomplete_reason, "stuck");
}

TEST(Backplot, ArcsAreChordsWithinTheToleranceInWorkCoordinates) {
  const auto machine = *machine::default_machine("fanuc-0i-m");
  interp::MachineData data;
  data.work[0] = {-100, -50, 0};
  BackplotLimits limits;
  limits.chord_mm = 0.01;
  const Backplot plot = backplot(machine, data,
                                 text("O1\nG90 G94 G21 G17 G54\nG00 X20. Y0.\nG03 X-20. Y0. I-20. J0. F500.\n"
                                      "G01 X0.\nM30\n"),
                                 nullptr, {}, limits);
  ASSERT_EQ(plot.moves.size(), 3u);
  EXPECT_EQ(plot.axes, (std::vector<char>{'X', 'Y', 'Z'}));
  EXPECT_EQ(plot.moves[0].kind, PlotKind::rapid);
  EXPECT_EQ(plot.moves[1].kind, PlotKind::arc);
  EXPECT_EQ(plot.moves[1].line, 4u);
  const auto& points = plot.moves[1].points;
  ASSERT_GT(points.size(), 30u);
  double x = 20, y = 0;
  for (std::size_t i = 0; i < points.size(); i += 3) {
    EXPECT_NEAR(std::hypot(points[i], points[i + 1]), 20, 1e-4);
    EXPECT_GT(std::hypot((x + points[i]) / 2, (y + points[i + 1]) / 2), 20 - 0.0101);
    x = points[i];
    y = points[i + 1];
  }
  EXPECT_NEAR(x, -20, 1e-4);
  EXPECT_NEAR(plot.max_mm[1], 50, 1e-9) << "the start at the reference point counts";
  EXPECT_FALSE(plot.truncated);
}

TEST(Backplot, IsBoundedAndTellsOfAnAlarm) {
  const auto machine = *machine::default_machine("fanuc-0i-m");
  BackplotLimits limits;
  limits.max_points = 10;
  std::string program = "O1\nG90 G94 G21\nG01 F500.\n";
  for (int i = 0; i < 100; ++i) program += "X" + std::to_string(i) + ".\n";
  EXPECT_TRUE(backplot(machine, {}, text(program + "M30\n"), nullptr, {}, limits).truncated);
  const Backplot alarm = backplot(machine, {}, text("O1\nG00 X1.\nG777\nM30\n"), nullptr);
  EXPECT_EQ(alarm.alarm_code, "PS0010");
  EXPECT_EQ(alarm.alarm_at.line, 3u);
  EXPECT_EQ(alarm.moves.size(), 1u);
}

}  // namespace
}  // namespace headstock::operation
