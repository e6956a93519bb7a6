// Programs that arrive in pieces, run for long, or try to run for ever.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "dialects/dialect.hpp"
#include "dripping.hpp"
#include "interpreter/interpreter.hpp"
#include "program/library.hpp"

namespace headstock::interp {
namespace {

struct Bench {
  explicit Bench(std::string_view profile)
      : machine(*machine::default_machine(profile)),
        interpreter(*dialects::find(profile), machine, data, &programs) {}
  machine::Machine machine;
  MachineData data;
  program::FilePrograms programs;
  Interpreter interpreter;

  std::vector<Operation> run(std::unique_ptr<program::Source> source, int* waits = nullptr) {
    interpreter.start(std::move(source), {});
    std::vector<Operation> made;
    Operation operation;
    for (;;) {
      const Pull pull = interpreter.next(operation);
      if (pull == Pull::finished) return made;
      if (pull == Pull::operation) made.push_back(operation);
      if (made.size() > 100'000) return made;
      if (pull == Pull::wait && waits != nullptr) ++*waits;
    }
  }
};

const Motion* motion(const Operation& operation) {
  if (const auto* rapid = std::get_if<Rapid>(&operation)) return rapid;
  if (const auto* feed = std::get_if<Feed>(&operation)) return feed;
  return std::get_if<Arc>(&operation);
}

TEST(Stream, OneByteAtATimeGivesTheSameAsTheWhole) {
  const std::string text =
      "%\r\nO0001 (\xd6\xd0)\r\nN1 G90 G54 G00 X1.5 Y-2.25 S1000 M03\r\nN2 G01 Z-1. F100.;X3.\r\n"
      "N3 G02 X5. Y0. R10.\nG91 G28 Z0\n\nM30\r\n%";
  Bench whole("fanuc-0i-m");
  const auto expected = whole.run(program::source_from_text(text));
  ASSERT_GT(expected.size(), 6u);
  for (const std::size_t piece : {1u, 2u, 3u, 7u}) {
    Bench dripping("fanuc-0i-m");
    int waits = 0;
    const auto made = dripping.run(std::make_unique<Dripping>(text, piece), &waits);
    EXPECT_GT(waits, 10);
    ASSERT_EQ(made.size(), expected.size());
    for (std::size_t i = 0; i < made.size(); ++i) {
      ASSERT_EQ(made[i].index(), expected[i].index());
      const Motion* a = motion(made[i]);
      const Motion* b = motion(expected[i]);
      ASSERT_EQ(a == nullptr, b == nullptr);
      if (a == nullptr) continue;
      EXPECT_EQ(a->end_machine, b->end_machine);
      EXPECT_EQ(a->at.line, b->at.line);
      EXPECT_EQ(a->at.byte_offset, b->at.byte_offset);
      EXPECT_EQ(a->at.sequence, b->at.sequence);
    }
  }
}

TEST(Stream, ByteOffsetIsTheBlocksFirstByte) {
  Bench bench("fanuc-0i-m");
  const std::string text = "G00 X1.\nX2.;X3.\nM30\n";
  const auto made = bench.run(program::source_from_text(text));
  ASSERT_EQ(made.size(), 4u);
  EXPECT_EQ(motion(made[0])->at.byte_offset, 0u);
  EXPECT_EQ(motion(made[1])->at.byte_offset, 8u);
  EXPECT_EQ(motion(made[2])->at.byte_offset, 12u);
  EXPECT_EQ(motion(made[2])->at.line, 2u);
}

TEST(Stream, AMillionIncrementsDoNotDrift) {
  std::string text = "G91 G00\n";
  for (int i = 0; i < 1'000'000; ++i) text += "X0.001 Y-0.0001 Z0.0003\n";
  text += "M30\n";
  Bench bench("fanuc-0i-m");
  bench.interpreter.start(program::source_from_text(text), {});
  Operation operation;
  AxisVector last{};
  while (bench.interpreter.next(operation) == Pull::operation) {
    if (const Motion* m = motion(operation)) last = m->end_work;
  }
  EXPECT_EQ(last[0], 1'000.0);
  EXPECT_EQ(last[1], -100.0);
  EXPECT_EQ(last[2], 300.0);
}

TEST(Stream, AMillionInchIncrementsDoNotDrift) {
  std::string text = "G20 G91 G00\n";
  for (int i = 0; i < 1'000'000; ++i) text += "X.0001\n";
  Bench bench("fanuc-0i-m");
  bench.interpreter.start(program::source_from_text(text), {});
  Operation operation;
  const Motion* m = nullptr;
  AxisVector work{}, slide{};
  while (bench.interpreter.next(operation) == Pull::operation) {
    if ((m = motion(operation)) != nullptr) work = m->end_work, slide = m->end_machine;
  }
  EXPECT_EQ(work[0], 100.0);
  EXPECT_DOUBLE_EQ(slide[0], 2'540.0);
}

TEST(Stream, TenMegabytesOnOneLineAreAnAlarmWithItsLine) {
  for (const std::string_view name : dialects::dialect_names()) {
    Bench bench(name);
    const auto made =
        bench.run(program::source_from_text("G00 X1.\nX" + std::string(10'000'000, '1') + "\n"));
    ASSERT_EQ(made.size(), 2u) << name;
    const auto* alarm = std::get_if<Alarm>(&made[1]);
    ASSERT_NE(alarm, nullptr);
    EXPECT_EQ(alarm->code, dialects::find(name)->alarm_code(dialects::AlarmReason::block_too_long));
    EXPECT_EQ(alarm->at.line, 2u);
  }
}

TEST(Stream, EmptyTextEnds) {
  for (const std::string_view name : dialects::dialect_names()) {
    for (const char* text : {"", "\n", "%\n", "(comment)\n"}) {
      Bench bench(name);
      const auto made = bench.run(program::source_from_text(text));
      ASSERT_EQ(made.size(), 1u) << name << " <" << text << ">";
      EXPECT_TRUE(std::holds_alternative<Alarm>(made[0]) || std::holds_alternative<End>(made[0]));
    }
  }
}

TEST(Stream, JumpBackInAStreamIsAnAlarm) {
  Bench bench("fanuc-0i-m");
  const auto made = bench.run(std::make_unique<Dripping>("N1 G00 X1.\nM99 P1\n", 3));
  ASSERT_EQ(made.size(), 2u);
  ASSERT_TRUE(std::holds_alternative<Alarm>(made[1]));
  EXPECT_EQ(std::get<Alarm>(made[1]).code, "PS0078");
}

TEST(Stream, AnEmptySubProgramCalledForEverIsBounded) {
  Bench bench("fanuc-0i-m");
  bench.programs.add_text("O2\nM99\n");
  const auto made = bench.run(program::source_from_text("M98 P2 L99999999\nM30\n"));
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(std::get<Alarm>(made[0]).code, "HS0001");
}

TEST(Modal, StateRidesOnEveryMove) {
  Bench bench("fanuc-0i-t");
  bench.data.tools.resize(3);
  bench.data.tools[2].geometry[0] = 4;
  const auto made = bench.run(program::source_from_text("G98 T0102\nG01 X10. F100\nG99 G00 X20.\nM30\n"));
  const auto& feed = std::get<Feed>(made[1]);
  const auto& rapid = std::get<Rapid>(made[2]);
  EXPECT_EQ(feed.modal.g[1], 10);
  EXPECT_EQ(feed.modal.g[5], 980);
  EXPECT_FALSE(feed.modal.per_revolution);
  EXPECT_TRUE(rapid.modal.per_revolution);
  EXPECT_EQ(rapid.modal.g[1], 0);
  EXPECT_EQ(feed.modal.tool, 1);
  EXPECT_EQ(feed.modal.offset, 2);
  EXPECT_EQ(feed.modal.feed, 100);
  EXPECT_EQ(feed.modal.work_zero[0], 2);
  EXPECT_EQ(bench.interpreter.to_work(feed.end_machine, feed.modal)[0], 10);
}

TEST(Modal, SetPositionAfterAnAbort) {
  Bench bench("fanuc-0i-m");
  bench.interpreter.start(program::source_from_text("G91 G00 X10.\nX10.\nM30\n"), {});
  Operation operation;
  ASSERT_EQ(bench.interpreter.next(operation), Pull::operation);
  bench.interpreter.set_position({3.5});
  ASSERT_EQ(bench.interpreter.next(operation), Pull::operation);
  EXPECT_EQ(std::get<Rapid>(operation).end_work[0], 13.5);
}

TEST(Modal, ResetLeavesTheProgramAndKeepsOrClearsTheState) {
  for (const bool clears : {false, true}) {
    Bench bench("fanuc-0i-m");
    if (clears) bench.data.parameters["3402#6"] = 1;
    bench.interpreter.start(program::source_from_text("G91 G01 X10. F100.\nX10.\nM30\n"), {});
    Operation operation;
    ASSERT_EQ(bench.interpreter.next(operation), Pull::operation);
    bench.interpreter.reset({});
    EXPECT_EQ(bench.interpreter.next(operation), Pull::finished);
    EXPECT_EQ(bench.interpreter.modal().g[3], clears ? 900 : 910);
    EXPECT_EQ(bench.interpreter.modal().g[1], clears ? 0 : 10);
  }
}

TEST(Data, WritesOfAProgramAreReported) {
  Bench bench("fanuc-0i-t");
  std::vector<std::string> seen;
  bench.interpreter.on_data_change([&](const DataChange& change) {
    seen.push_back(change.what + " " + std::to_string(change.before) + " " + std::to_string(change.after));
  });
  bench.run(program::source_from_text("G10 P3 X1.5 W0.25\nG10 P10003 R0.4\nG10 L2 P2 Z5.\nM30\n"));
  EXPECT_EQ(seen,
            (std::vector<std::string>{"tool/3/wear/Z 0.000000 0.250000", "tool/3/wear/X 0.000000 1.500000",
                                      "tool/3/radius 0.000000 0.400000", "work/G55/Z 0.000000 5.000000"}));
}

}  // namespace
}  // namespace headstock::interp
