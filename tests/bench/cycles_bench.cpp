// What a canned cycle costs against the same number of plain blocks, in one run.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <string>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"

namespace {

using namespace headstock;

std::size_t run_on(const char* profile, const std::string& text) {
  const dialects::Dialect* dialect = dialects::find(profile);
  const machine::Machine machine = *machine::default_machine(profile);
  interp::MachineData data;
  data.tools.resize(2);
  data.tools[1].radius = 1;
  interp::Interpreter interpreter(*dialect, machine, data, nullptr);
  interpreter.start(program::source_from_text(text), {});
  interp::Operation operation;
  std::size_t count = 0;
  while (interpreter.next(operation) == interp::Pull::operation) {
    if (std::holds_alternative<interp::Alarm>(operation)) return 0;
    ++count;
  }
  return count;
}

std::size_t run(const std::string& text) {
  return run_on("fanuc-0i-t", text);
}
std::size_t run_mill(const std::string& text) {
  return run_on("fanuc-0i-m", text);
}

// A shaft of 1,000 blocks, monotonic, roughed in 40 cuts.
std::string roughing() {
  std::string text = "O1\nG98 G00 X240. Z5.\nG71 U2.5 R0.5\nG71 P10 Q20 U1. W0.2 F200\nN10 G00 X40.\n";
  char line[64];
  for (int i = 1; i <= 998; ++i) {
    std::snprintf(line, sizeof line, "G01 X%.3f Z%.3f\n", 40 + 0.195 * i, -0.3 * i + 0.1 * std::sin(i));
    text += line;
  }
  return text + "N20 X236. Z-310.\nM30\n";
}

std::string plain(std::size_t blocks) {
  std::string text = "O1\nG98 G01 F200\n";
  char line[64];
  for (std::size_t i = 0; i < blocks; ++i) {
    std::snprintf(line, sizeof line, "G01 X%.3f Z%.3f\n", 40 + 0.01 * static_cast<double>(i % 900),
                  -0.3 * static_cast<double>(i % 700));
    text += line;
  }
  return text + "M30\n";
}

void BM_G71_1000_blocks(benchmark::State& state) {
  const std::string text = roughing();
  std::size_t made = 0;
  for (auto _ : state) benchmark::DoNotOptimize(made = run(text));
  if (made == 0) state.SkipWithError("alarm");
  state.counters["operations"] = static_cast<double>(made);
}
BENCHMARK(BM_G71_1000_blocks)->Unit(benchmark::kMillisecond);

// A contour of lines and arcs; with G41 its cost is compared with the same contour without.
std::string contour(bool compensated, std::size_t blocks, std::size_t arc_every = 5) {
  std::string text = compensated ? "O1\nG90 G94 G00 X-10. Y0\nG41 G01 X0 Y0 D1 F500\n"
                                 : "O1\nG90 G94 G00 X-10. Y0\nG01 X0 Y0 F500\n";
  char line[80];
  for (std::size_t i = 0; i < blocks; ++i) {
    const double x = 10.0 * static_cast<double>(i + 1), y = i % 2 == 0 ? 6 : 0;
    if (arc_every > 0 && i % arc_every == arc_every - 1) {
      std::snprintf(line, sizeof line, "G02 X%.3f Y%.3f R20.\nG01\n", x, y);
    } else {
      std::snprintf(line, sizeof line, "X%.3f Y%.3f\n", x, y);
    }
    text += line;
  }
  return text + "G40 X0 Y-10.\nM30\n";
}

void run_contour(benchmark::State& state, bool compensated) {
  const std::string text = contour(compensated, 10'000);
  std::size_t made = 0;
  for (auto _ : state) benchmark::DoNotOptimize(made = run_mill(text));
  if (made == 0) state.SkipWithError("alarm");
  state.counters["operations"] = static_cast<double>(made);
  state.counters["blocks_per_s"] = benchmark::Counter(10'000, benchmark::Counter::kIsIterationInvariantRate);
}
void BM_contour_plain(benchmark::State& state) {
  run_contour(state, false);
}
void BM_contour_compensated(benchmark::State& state) {
  run_contour(state, true);
}
BENCHMARK(BM_contour_plain)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_contour_compensated)->Unit(benchmark::kMillisecond);

double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// What compensation adds to the plain interpreter, as a share of it: below 1. Both by turns, the best of each, so
// that what else the machine does counts for neither. Argument: every how many blocks an arc stands; 0: lines only.
void BM_compensation_over_plain(benchmark::State& state) {
  const auto arcs = static_cast<std::size_t>(state.range(0));
  const std::array<std::string, 2> text{contour(false, 10'000, arcs), contour(true, 10'000, arcs)};
  std::array<double, 2> best{1e9, 1e9};
  std::size_t made = 1;
  for (auto _ : state) {
    for (std::size_t k = 0; k < 2; ++k) {
      const double begin = cpu_s();
      made = std::min(made, run_mill(text[k]));
      best[k] = std::min(best[k], cpu_s() - begin);
    }
  }
  if (made == 0) state.SkipWithError("alarm");
  state.counters["extra_over_plain"] = best[1] / best[0] - 1;
}
BENCHMARK(BM_compensation_over_plain)->Arg(0)->Arg(5)->Arg(2)->Iterations(30)->Unit(benchmark::kMillisecond);

// The reference: as many plain blocks as the cycle reads and makes.
void BM_plain_blocks(benchmark::State& state) {
  const std::string text = plain(1'000 + run(roughing()));
  std::size_t made = 0;
  for (auto _ : state) benchmark::DoNotOptimize(made = run(text));
  if (made == 0) state.SkipWithError("alarm");
  state.counters["operations"] = static_cast<double>(made);
}
BENCHMARK(BM_plain_blocks)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
