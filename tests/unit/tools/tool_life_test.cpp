// Choosing, counting, marks; and cutting time through the interpreter.
#include "tools/tool_life.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"

namespace headstock::tools {
namespace {

LifeGroup group(std::int64_t life, std::vector<LifeTool> tools) {
  LifeGroup made;
  made.life = life;
  made.tools = std::move(tools);
  return made;
}

LifeTool tool(std::int32_t number, std::int64_t used = 0, std::int32_t offset = 0) {
  LifeTool made;
  made.tool = number;
  made.offset = offset;
  made.used = used;
  return made;
}

TEST(ToolLife, TheCurrentToolStaysUntilItsLifeIsSpent) {
  LifeGroup g = group(2, {tool(1), tool(2)});
  EXPECT_EQ(choose(g), 0u);
  use(g, 0, 1, SharedLife::per_tool);
  EXPECT_EQ(choose(g), 0u);
  use(g, 0, 1, SharedLife::per_tool);
  EXPECT_EQ(choose(g), 1u);
  EXPECT_EQ(mark(g, 0), LifeMark::expired);
}

TEST(ToolLife, TheSearchGoesRoundToTheFirst) {
  LifeGroup g = group(2, {tool(1), tool(2, 2), tool(3, 2)});
  g.current = 2;
  EXPECT_EQ(choose(g), 0u);
}

TEST(ToolLife, WithoutLifeLeftTheLastToolAgain) {
  const LifeGroup g = group(1, {tool(1, 1), tool(2, 5, 2), tool(2, 5, 3)});
  EXPECT_TRUE(all_spent(g));
  EXPECT_EQ(choose(g), 1u);  // its first offset
}

TEST(ToolLife, OffsetsOfOneToolShareItsLifeUnlessCountedOneByOne) {
  LifeGroup g = group(5, {tool(2, 0, 2), tool(2, 0, 3), tool(4)});
  use(g, 1, 3, SharedLife::per_tool);
  EXPECT_EQ(g.tools[0].used, 3);
  EXPECT_EQ(g.tools[1].used, 3);
  EXPECT_EQ(g.tools[2].used, 0);
  use(g, 1, 2, SharedLife::per_entry);
  EXPECT_EQ(g.tools[0].used, 3);
  EXPECT_EQ(g.tools[1].used, 5);
  EXPECT_EQ(choose(g), 0u);
}

TEST(ToolLife, TheNextOffsetEndsAtTheToolsLast) {
  const LifeGroup g = group(5, {tool(2), tool(2), tool(4)});
  EXPECT_EQ(next_offset(g, 0), 1u);
  EXPECT_EQ(next_offset(g, 1), 1u);
}

TEST(ToolLife, SkipPassesOverAndRenewBeginsAgain) {
  LifeGroup g = group(5, {tool(1, 2), tool(2)});
  ASSERT_TRUE(skip_current(g));
  EXPECT_EQ(mark(g, 0), LifeMark::skipped);
  EXPECT_EQ(remaining(g), 0);
  EXPECT_EQ(choose(g), 1u);
  g.current = 1;
  EXPECT_EQ(mark(g, 1), LifeMark::in_use);
  renew(g);
  EXPECT_EQ(choose(g), 0u);
  EXPECT_EQ(g.tools[0].used, 0);
  EXPECT_EQ(mark(g, 0), LifeMark::in_use);
  EXPECT_EQ(mark(g, 1), LifeMark::available);
  LifeGroup none;
  EXPECT_FALSE(skip_current(none));
}

// Cutting time is told from outside; the interpreter knows which tool it belongs to.
class CuttingTime : public testing::Test {
 protected:
  CuttingTime() {
    data.parameters["8132#0"] = 1;
    LifeGroup g = group(20, {tool(1, 0, 1), tool(2, 0, 2)});
    g.unit = LifeUnit::tenths;
    data.tool_life.groups[1] = g;
  }
  // Every cutting move takes 1.95 s.
  void run(const char* program) {
    interpreter.start(program::source_from_text(program), {});
    interp::Operation operation;
    while (interpreter.next(operation) == interp::Pull::operation) {
      if (const auto* change = std::get_if<interp::Tool>(&operation)) chosen.push_back(change->tool);
      if (std::holds_alternative<interp::Feed>(operation)) interpreter.tool_cut_for(1.95);
    }
  }
  std::int64_t used(std::size_t entry) { return data.tool_life.groups[1].tools[entry].used; }

  const dialects::Dialect& dialect = *dialects::find("fanuc-0i-t");
  machine::Machine machine = *machine::default_machine("fanuc-0i-t");
  interp::MachineData data;
  interp::Interpreter interpreter{dialect, machine, data, nullptr};
  std::vector<std::int32_t> chosen;
};

TEST_F(CuttingTime, IsCountedInWholeSecondsForTheToolInUse) {
  run("O1\nT0199;\nG98 G01 X10. F100.;\nX20.;\nT0301;\nG01 X30. F100.;\nM30;\n");
  EXPECT_EQ(used(0), 30);  // 3.9 s; the rest below a second is dropped
  EXPECT_EQ(used(1), 0);
}

TEST_F(CuttingTime, OfLessThanASecondCountsAsOneWhenToldSo) {
  data.parameters["6805#6"] = 1;
  run("O1\nT0199;\nG98 G01 X10. F100.;\nT0301;\nM30;\n");
  EXPECT_EQ(used(0), 20);
}

TEST_F(CuttingTime, ASpentToolIsReplacedInTheSameRunAndTheLastOneSignalsAtOnce) {
  std::vector<std::string> changes;
  interpreter.on_data_change([&](const interp::DataChange& change) { changes.push_back(change.what); });
  run("O1\nT0199;\nG98 G01 X10. F100.;\nX20.;\nT0199;\nX30. F100.;\nX40.;\nM30;\n");
  EXPECT_EQ(chosen, (std::vector<std::int32_t>{1, 2}));
  EXPECT_TRUE(data.tool_life.change_due);
  EXPECT_EQ(std::count(changes.begin(), changes.end(), "tool_life/change_due"), 1);
}

TEST_F(CuttingTime, InTenthsWhenTheParameterSaysSo) {
  data.parameters["6805#0"] = 1;
  run("O1\nT0199;\nG98 G01 X10. F100.;\nM30;\n");
  EXPECT_EQ(used(0), 19);
}

TEST_F(CuttingTime, EveryMinuteIsReported) {
  data.tool_life.groups[1].life = 100'000;
  std::vector<double> reported;
  interpreter.on_data_change([&](const interp::DataChange& change) {
    if (change.what == "tool_life/1/used/0") reported.push_back(change.after);
  });
  run("O1\nT0199;\nM30;\n");
  for (int i = 0; i < 150; ++i) interpreter.tool_cut_for(1);
  EXPECT_EQ(reported, (std::vector<double>{60, 120}));
  interpreter.reset({});
  EXPECT_EQ(reported.back(), 150);
  EXPECT_EQ(used(0), 1500);
}

}  // namespace
}  // namespace headstock::tools
