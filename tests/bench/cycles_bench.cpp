// What a canned cycle costs against the same number of plain blocks, in one run.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"

namespace {

using namespace headstock;

std::size_t run(const std::string& text) {
  const dialects::Dialect* dialect = dialects::find("fanuc-0i-t");
  const machine::Machine machine = *machine::default_machine("fanuc-0i-t");
  interp::MachineData data;
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
    std::snprintf(line, sizeof line, "G01 X%.3f Z%.3f\n", 40 + 0.01 * static_cast<double>(i % 900), -0.3 * static_cast<double>(i % 700));
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
