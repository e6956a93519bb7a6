// What is remembered of G10 for a RESET: what may still have to be taken back, however long the program is.
#include <gtest/gtest.h>

#include <string>

#include "dialects/dialect.hpp"
#include "interpreter/executor.hpp"
#include "macro/environment.hpp"

namespace headstock::interp {
namespace {

struct CarriedOut final : macro::Environment {
  bool takes_time() const override { return true; }
};

struct DataInputToTakeBack : testing::Test {
  machine::Machine machine = *machine::default_machine("fanuc-0i-m");
  MachineData data;
  Executor executor{*dialects::find("fanuc-0i-m"), machine, data, nullptr};
  std::size_t most = 0;
  int written = 0;

  /// As whoever carries out the moves: at a standstill everything handed out is done.
  void run(const std::string& program) {
    executor.changed = [this](const DataChange&) { ++written; };
    executor.start(program::source_from_text(program), {});
    Operation operation;
    std::uint32_t done = 0;
    for (Pull pull = executor.next(operation); pull != Pull::finished; pull = executor.next(operation)) {
      if (pull == Pull::standstill) executor.keep_data_input(done + 1);
      if (const Motion* motion = pull == Pull::operation ? motion_in(operation) : nullptr; motion != nullptr)
        done = motion->at.block;
      ASSERT_FALSE(pull == Pull::operation && std::holds_alternative<Alarm>(operation));
      most = std::max(most, executor.data_input_ahead.size());
    }
  }
};

TEST_F(DataInputToTakeBack, IsWhatStandsBehindTheMotionsHeldHoweverLongTheProgram) {
  CarriedOut environment;
  executor.environment = &environment;
  std::string program = "O1\nG90 G94 G41 G01 X2. D1 F600.\n";
  for (int n = 1; n <= 500; ++n)
    program += "X" + std::to_string(2 + n) + ".\nG10 L12 P2 R" + std::to_string(n % 2 + 1) + ".\n";
  run(program + "G40 X600.\nM30\n");
  EXPECT_EQ(written, 500);
  EXPECT_GE(most, 1u);
  EXPECT_LE(most, 3u);
}

TEST_F(DataInputToTakeBack, IsNothingWhereNothingIsCarriedOut) {
  run("O1\nG90 G94 G41 G01 X2. D1 F600.\nX3.\nG10 L12 P2 R1.\nX4.\nG40 X6.\nM30\n");
  EXPECT_EQ(written, 1);
  EXPECT_EQ(most, 0u);
}

}  // namespace
}  // namespace headstock::interp
