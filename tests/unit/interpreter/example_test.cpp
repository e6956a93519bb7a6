// Worked examples of the manuals that a case file cannot show: they look at inputs, clocks, block numbers, or
// at what is read while something moves (0i-D, numbers of tests/conformance/examples.tsv).
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "macro/environment.hpp"
#include "program/library.hpp"

namespace headstock::interp {
namespace {

struct ExampleBench {
  explicit ExampleBench(std::string_view profile = "fanuc-0i-m")
      : machine(*machine::default_machine(profile)),
        interpreter(*dialects::find(profile), machine, data, &programs) {}
  machine::Machine machine;
  MachineData data;
  program::FilePrograms programs;
  Interpreter interpreter;
  Operation operation;
  std::string text;

  void start(std::string program) {
    text = std::move(program);
    interpreter.start(program::source_from_text(text), {});
  }
  Pull next() { return interpreter.next(operation); }
  std::vector<Operation> all() {
    std::vector<Operation> made;
    while (made.size() < 10'000 && next() == Pull::operation) made.push_back(operation);
    return made;
  }
  const SourcePosition& at() const {
    return std::visit([](const auto& o) -> const SourcePosition& { return o.at; }, operation);
  }
};

double end_x(const Operation& operation) {
  if (const auto* rapid = std::get_if<Rapid>(&operation)) return rapid->end_work[0];
  if (const auto* feed = std::get_if<Feed>(&operation)) return feed->end_work[0];
  return 1e9;
}

// Digits at inputs 0-11, sign at 12, of whatever the address at outputs 0-3 asks for.
struct BcdReader final : macro::Environment {
  virtual int wanted() const {
    int address = 0;
    for (unsigned bit = 0; bit < 4; ++bit) address |= output(bit) ? 1 << bit : 0;
    return address;
  }
  bool input(unsigned bit) const override {
    const int value = values.at(static_cast<std::size_t>(wanted()));
    if (bit == 12) return value < 0;
    if (bit > 12) return false;
    int digits = std::abs(value);
    for (unsigned i = 0; i < bit / 4; ++i) digits /= 10;
    return (digits % 10 >> bit % 4 & 1) != 0;
  }
  std::vector<int> values = std::vector<int>(16, 0);
};

constexpr const char* kBcdMacros =
    "O9100\n#1132=#1132 AND 496 OR #7\nG65 P9102 T60\n#100=BIN[#1032 AND 4095]\nIF[#1012 EQ 0]GOTO 9100\n"
    "#100=-#100\nN9100 M99\n"
    "O9102\n#3001=0\nWHILE[#3001 LE #20]DO1\nEND1\nM99\n"
    "O9101\nG65 P9100 D[#7*2+1]\n#101=#100\nG65 P9100 D[#7*2]\n#101=#101+#100/1000\nM99\n";

// b E6, L14657. The timer has a number of its own here: the manual gives E6's and E7's programs the same.
TEST(Examples, SignedBcdThroughTheInputs) {
  ExampleBench bench;
  BcdReader environment;
  environment.values[5] = -123;
  environment.values[6] = 45;
  environment.set_output(6, true);  // another use of outputs 4-8
  bench.interpreter.set_environment(&environment);
  bench.programs.add_text(kBcdMacros);
  bench.start("G65 P9100 D5\nG90 G00 X#100\nG65 P9100 D6\nX#100\nM30\n");
  const std::vector<Operation> made = bench.all();
  ASSERT_EQ(made.size(), 3u);
  EXPECT_EQ(end_x(made[0]), -123);
  EXPECT_EQ(end_x(made[1]), 45);
  EXPECT_TRUE(environment.output(6));
}

// b E7, L14677, with the manual's misprint corrected (#7 for #1, no call of itself).
TEST(Examples, EightSignedBcdData) {
  ExampleBench bench;
  BcdReader environment;
  environment.values[2 * 3 + 1] = -12;
  environment.values[2 * 3] = -345;
  environment.values[2 * 7 + 1] = 999;
  environment.values[2 * 7] = 1;
  bench.interpreter.set_environment(&environment);
  bench.programs.add_text(kBcdMacros);
  bench.start("G65 P9101 D3\nG90 G00 X#101\nG65 P9101 D7\nX#101\nM30\n");
  const std::vector<Operation> made = bench.all();
  ASSERT_EQ(made.size(), 3u);
  EXPECT_NEAR(end_x(made[0]), -12.345, 1e-9);
  EXPECT_NEAR(end_x(made[1]), 999.001, 1e-9);
}

// b E22, L19674: M03 and M05 call programs that add the hours of each tool.
TEST(Examples, ToolUseTime) {
  struct Clock final : macro::Environment {
    double clock_hours() override { return hours; }
    void set_clock_hours(double value) override { hours = value; }
    double hours = 77;
  };
  ExampleBench bench;
  Clock environment;
  bench.interpreter.set_environment(&environment);
  bench.data.parameters["6071"] = 3;
  bench.data.parameters["6072"] = 5;
  for (std::uint32_t i = 501; i <= 505; ++i) bench.data.common_variables[i] = 0;
  bench.programs.add_text(
      "O9001\nM01\nIF[#4120 EQ 0]GOTO 9\nIF[#4120 GT 5]GOTO 9\n#3002=0\nN9 M03\nM99\n"
      "O9002\nM01\nIF[#4120 EQ 0]GOTO 9\nIF[#4120 GT 5]GOTO 9\n#[500+#4120]=#3002+#[500+#4120]\nN9 "
      "M05\nM99\n");
  std::string program = "O0001\n";
  for (int i = 1; i <= 5; ++i) program += "T0" + std::to_string(i) + " M06\nM03\nM05\n";
  bench.start(program + "T02 M06\nM03\nM05\nM30\n");
  int tool = 0;
  while (bench.next() == Pull::operation) {
    if (const auto* chosen = std::get_if<Tool>(&bench.operation)) tool = chosen->tool;
    const auto* m = std::get_if<MCode>(&bench.operation);
    if (m != nullptr && m->code == 3) environment.hours += 0.25 * tool;  // it cuts until M05
    ASSERT_FALSE(std::holds_alternative<Alarm>(bench.operation));
  }
  for (std::uint32_t i = 1; i <= 5; ++i)
    EXPECT_EQ(bench.data.common_variables.at(500 + i), 0.25 * i * (i == 2 ? 2 : 1)) << i;
}

// b E40, L19820: nothing behind G31 is looked at before it is over; other statements wait for nothing.
TEST(Examples, WhatIsReadWhileABlockMoves) {
  struct TakesTime final : macro::Environment {
    bool takes_time() const override { return true; }
  } environment;
  {
    ExampleBench bench;
    bench.interpreter.set_environment(&environment);
    bench.start("N1 G31 X100.0 F100\nN2 #100=1\nN3 G00 X0\nM30\n");
    ASSERT_EQ(bench.next(), Pull::operation);
    EXPECT_FALSE(bench.data.common_variables.contains(100));
    bench.interpreter.skip_ended({40}, true);
    ASSERT_EQ(bench.next(), Pull::operation);
    EXPECT_EQ(bench.data.common_variables.at(100), 1);
  }
  for (const char* text :
       {"N1 G00 X100.0\nN2 #1=100\nN3 #2=200\nN4 Y200.0\nM30\n",
        "N1 G01 G41 X100.0 F100 D1\nN2 #1=100\nN3 Y100.0\nN4 #2=200\nN5 Y150.0\nN6 #3=300\n"
        "N7 X200.0\nG40 X300.\nM30\n"}) {
    ExampleBench bench;
    bench.interpreter.set_environment(&environment);
    bench.data.tools.resize(2);
    bench.data.tools[1].radius = 2;
    bench.start(text);
    Pull pull = bench.next();
    for (int i = 0; i < 20 && pull == Pull::operation; ++i) pull = bench.next();
    EXPECT_EQ(pull, Pull::finished) << text;  // never at a standstill
    EXPECT_TRUE(std::holds_alternative<End>(bench.operation)) << text;
  }
}

std::vector<std::uint32_t> blocks_of(const std::vector<Operation>& made) {
  std::vector<std::uint32_t> blocks;
  for (const Operation& operation : made) {
    const std::uint32_t block = std::visit([](const auto& o) { return o.at.block; }, operation);
    if (blocks.empty() || blocks.back() != block) blocks.push_back(block);
  }
  return blocks;
}

// c1 E13, L31468: the O block is the first.
TEST(Examples, BlockNumbersOfAPlainProgram) {
  ExampleBench bench;
  bench.start("O0001\nG90 G92 X0 Y0 Z0\nG01 X100. F100\nG01 Z-50. F50\nM30\n");
  EXPECT_EQ(blocks_of(bench.all()), (std::vector<std::uint32_t>{3, 4, 5}));
  RestartPoint point;
  point.block = 4;
  ASSERT_EQ(bench.interpreter.restart(program::source_from_text(bench.text), {}, point), Pull::operation);
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(std::get<Feed>(bench.operation).end_work[2], -50);
}

// c1 E14, L31493: macro statements are not counted.
TEST(Examples, BlockNumbersLeaveMacroStatementsOut) {
  ExampleBench bench;
  bench.start(
      "O0001\nG90 G92 X0 Y0 Z0\nG90 G00 Z100.\nG81 X100. Y0. Z-120. R80. F50.\n#1=#1+1\n#2=#2+1\n#3=#3+1\n"
      "G00 X0 Z0\nM30\n");
  EXPECT_EQ(blocks_of(bench.all()), (std::vector<std::uint32_t>{3, 4, 5, 6}));
  RestartPoint point;
  point.block = 5;
  ASSERT_EQ(bench.interpreter.restart(program::source_from_text(bench.text), {}, point), Pull::operation);
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(std::get<Rapid>(bench.operation).end_work[2], 0);
}

// c1 E29, L38382: only inside the program that is selected.
TEST(Examples, ASequenceNumberIsSearchedInItsOwnProgram) {
  ExampleBench bench;
  bench.programs.add_text(
      "O0001\nN01234 G90 G00 X100.0 Z100.0\nS12\nM30\nO0002\nN02345 G90 G00 X20.0 Z20.0\nN02346 X10.0 "
      "Y10.0\nM30\n"
      "O0003\nM30\n");
  RestartPoint point;
  point.sequence = 2346;
  ASSERT_EQ(bench.interpreter.restart(bench.programs.open_number(2), {}, point), Pull::operation);
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(end_x(bench.operation), 10);
  point.sequence = 1234;
  ASSERT_EQ(bench.interpreter.restart(bench.programs.open_number(2), {}, point), Pull::finished);
  ASSERT_EQ(bench.next(), Pull::operation);
  EXPECT_EQ(std::get<Alarm>(bench.operation).code, "PS0078");
}

// K.32.1, L80583: RESET takes back what was read and not carried out.
TEST(Reset, TakesBackWhatWasReadAndNotCarriedOut) {
  for (const bool whole : {false, true}) {
    ExampleBench bench;
    bench.data.work[0][0] = 10;
    bench.data.work[1][0] = 200;
    bench.start(
        "G90 G94 G21 G54 G17\nG01 X1. F100.\nG91 G55 G18 G96 S50\nG43 H1 Z0\nG52 X5.\nG20 X1. F3.\nG00 "
        "X2.\nM30\n");
    ASSERT_EQ(bench.next(), Pull::operation);
    const std::uint32_t moved = bench.at().block;
    while (bench.next() == Pull::operation && !std::holds_alternative<End>(bench.operation)) {
    }
    bench.interpreter.reset({11}, whole ? 0 : moved + 1);
    const ModalSnapshot& modal = bench.interpreter.modal();
    EXPECT_EQ(modal.g[1], whole ? 0 : 10);
    EXPECT_EQ(modal.g[3], whole ? 910 : 900);
    EXPECT_EQ(modal.g[14], whole ? 550 : 540);
    EXPECT_EQ(modal.inch, whole);
    if (whole) continue;
    EXPECT_EQ(modal.feed, 100);
    EXPECT_EQ(bench.interpreter.to_work({11}, modal)[0], 1);
    bench.start("X3.\nM30\n");  // the next program finds what the operator saw
    ASSERT_EQ(bench.next(), Pull::operation);
    const auto& feed = std::get<Feed>(bench.operation);
    EXPECT_EQ(feed.end_machine[0], 13);
    EXPECT_EQ(feed.feed, 100);
  }
}

// A long program of mode changes keeps a bounded number of them, and the newest are right.
TEST(Reset, OfManyChangesTheNewestAreKept) {
  ExampleBench bench;
  std::string program;
  for (int i = 1; i <= 5'000; ++i)
    program +=
        "G" + std::to_string(54 + i % 2) + " G01 X" + std::to_string(i) + ". F" + std::to_string(i) + ".\n";
  bench.start("G90 G94 G21\n" + program + "M30\n");
  while (bench.next() == Pull::operation) {
  }
  bench.interpreter.reset({}, 4'902);  // block 1 sets modes; block n + 1 has F n
  EXPECT_EQ(bench.interpreter.modal().feed, 4'900);
  EXPECT_EQ(bench.interpreter.modal().g[14], 540);
}

}  // namespace
}  // namespace headstock::interp
