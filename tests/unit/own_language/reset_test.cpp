// RESET and what a language of its own remembers (interpreter/modal_memory.hpp).
#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "program/library.hpp"

namespace headstock::interp {
namespace {

machine::Machine lathe_with_y() {
  machine::Machine made = *machine::default_machine("k2000tc");
  machine::Axis y = made.axes[1];
  y.name = 'Y';
  made.axes.resize(2);
  made.axes.push_back(y);
  return made;
}

struct Bench {
  machine::Machine machine = lathe_with_y();
  MachineData data;
  program::FilePrograms programs;
  Interpreter interpreter{*dialects::find("k2000tc"), machine, data, &programs};

  // The ends of the moves; empty after an alarm.
  std::vector<AxisVector> run(const char* text, const AxisVector& from = {}) {
    interpreter.start(program::source_from_text(text), from);
    std::vector<AxisVector> ends;
    Operation operation;
    while (interpreter.next(operation) == Pull::operation) {
      if (std::holds_alternative<Alarm>(operation)) return {};
      if (const auto* feed = std::get_if<Feed>(&operation)) ends.push_back(feed->end_machine);
    }
    return ends;
  }
};

constexpr const char* kSpiral = "G98 G03.3 X0 Q720. P1 F500.\nM30\n";

// NI NJ NK hold for later blocks (L6190).
TEST(ResetOfOwnModes, TheNormalIsThatOfTheLastBlockCarriedOut) {
  Bench kept, broken;
  const char* text = "G00 X100. Y0 Z0\nNI1. NJ1. NK1. G98 G03.3 X0 Q720. P1 F500.\nM30\n";
  ASSERT_FALSE(kept.run(text).empty());
  ASSERT_FALSE(broken
                   .run("G00 X100. Y0 Z0\nNI1. NJ1. NK1. G98 G03.3 X0 Q720. P1 F500.\n"
                        "NI0 NJ0 NK1. G02.3 X100. Q720. P1\nM30\n")
                   .empty());
  const AxisVector from{50, 0, 0};
  kept.interpreter.reset(from, 0);
  broken.interpreter.reset(from, 3);
  const auto as_kept = kept.run(kSpiral, from), as_broken = broken.run(kSpiral, from);
  ASSERT_GT(as_kept.size(), 10u);
  EXPECT_EQ(as_kept, as_broken);
}

}  // namespace
}  // namespace headstock::interp
