// G78.1 of K2000TC: quarter circles onto and off the thread, and an angle that follows from Z alone.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "program/library.hpp"

namespace headstock::interp {
namespace {

machine::Machine lathe_with_c_axis() {
  machine::Machine made = *machine::default_machine("k2000tc");
  machine::Axis c = made.axes[1];
  c.name = 'C';
  c.rotary = true;
  made.axes.resize(2);
  made.axes.push_back(c);
  return made;
}

TEST(SpindleThreadCycle, ArcsLeadOntoTheThreadAndTheSpindleFollowsZ) {
  const machine::Machine machine = lathe_with_c_axis();
  MachineData data;
  program::FilePrograms programs;
  Interpreter interpreter(*dialects::find("k2000tc"), machine, data, &programs);
  interpreter.start(program::source_from_text("G98 G00 X80. Z100. ;\nG07.2 P23 NF5. ;\n"
                                              "G78.1 X30. Z20. Q90. NB3. NE2. L1 F50. ;\nM30 ;\n"),
                    {});
  std::vector<Feed> feeds;
  Operation operation;
  while (interpreter.next(operation) == Pull::operation) {
    ASSERT_FALSE(std::holds_alternative<Alarm>(operation)) << std::get<Alarm>(operation).code;
    if (const auto* feed = std::get_if<Feed>(&operation)) feeds.push_back(*feed);
  }
  ASSERT_GT(feeds.size(), 40u);
  EXPECT_NEAR(feeds.front().end_machine[0], 15 + 3, 1e-6);  // a radius of NB above the thread
  EXPECT_NEAR(feeds.front().end_machine[1], 100, 1e-6);
  EXPECT_NEAR(feeds.back().end_machine[0], 40, 1e-6);
  EXPECT_NEAR(feeds.back().end_machine[1], 20, 1e-6);
  bool cut = false;
  for (const Feed& feed : feeds) {
    const double x = feed.end_machine[0], z = feed.end_machine[1];
    EXPECT_NEAR(feed.end_machine[2], 90 + 72 * (z - 100), 1e-4);  // 360 degrees every 5 mm
    if (z > 97 + 1e-6 && &feed != &feeds.front()) {
      EXPECT_NEAR(std::hypot(z - 97, x - 18), 3, 1e-6) << z;  // about (97, 18): onto the thread at Z97
    }
    if (z < 22 - 1e-6 && &feed != &feeds.back()) {
      EXPECT_NEAR(std::hypot(z - 22, x - 17), 2, 1e-6) << z;
    }
    if (std::fabs(z - 22) < 1e-6 && std::fabs(x - 15) < 1e-6) cut = true;
  }
  EXPECT_TRUE(cut);
}

}  // namespace
}  // namespace headstock::interp
