// Compensation, corners and cycles read ahead. A program that arrives byte by byte, with nothing every second
// time, must mean the same as the whole: no motion early, none twice, none lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "dialects/dialect.hpp"
#include "dripping.hpp"
#include "interpreter/interpreter.hpp"

namespace headstock::interp {
namespace {

struct Move {
  std::size_t kind;
  AxisVector end;
  std::uint32_t line, part;
  bool operator==(const Move&) const = default;
};

std::vector<Move> run(std::string_view profile, std::unique_ptr<program::Source> source,
                      const std::string& parameters, int* waits = nullptr) {
  const machine::Machine machine = *machine::default_machine(profile);
  MachineData data;
  std::vector<char> names;
  for (const auto& axis : machine.axes) names.push_back(axis.name);
  EXPECT_EQ(load_offsets(R"({"tools": {"1": {"radius": 2, "tip": 3}}})", names, data), "");
  EXPECT_EQ(load_parameters(parameters, data), "");
  Interpreter interpreter(*dialects::find(profile), machine, data, nullptr);
  interpreter.start(std::move(source), {});
  std::vector<Move> made;
  Operation operation;
  for (;;) {
    switch (interpreter.next(operation)) {
      case Pull::finished:
        return made;
      case Pull::operation:
        std::visit(
            [&](const auto& op) {
              AxisVector end{};
              if constexpr (std::is_base_of_v<Motion, std::decay_t<decltype(op)>>) end = op.end_machine;
              made.push_back({operation.index(), end, op.at.line, op.at.part});
            },
            operation);
        break;
      case Pull::wait:
        if (waits != nullptr) ++*waits;
        break;
      default:
        break;
    }
    if (made.size() > 10'000) return made;
  }
}

struct Case {
  const char* name;
  const char* profile;
  const char* parameters;
  const char* text;
};

constexpr Case kCases[] = {
    {"corners of every kind", "fanuc-0i-m", "{}",
     "G90 G94 G00 X-10. Y-10.\nG41 G01 X0 Y0 D1 F300\nY30.\nX20. Y40.\nG02 X40. Y20. R20.\nM08\nG04 "
     "P100\nG01 "
     "Y10.\nX30. Y-5.\nG40 X0 Y-10.\nM30\n"},
    {"two quiet blocks and a side change", "fanuc-0i-m", "{}",
     "G90 G94 G42 G01 X10. Y0 D1 F300\nX40.\nM08\nM09\nY30.\nG41 X60.\nY60.\nG40 X80.\nM30\n"},
    {"type C", "fanuc-0i-m", R"({"5003#1": 1})",
     "G90 G94 G00 X10. Y10. D1\nG41\nG01 Y50. F100\nX50.\nG40\nG00 X0 Y0\nM30\n"},
    {"a block left out", "fanuc-0i-m", R"({"19607#5": 1})",
     "G90 G94 G01 G41 X10. D1 F100\nX30.\nX30.3 Y.3\nY40.\nX60.\nG40 X80.\nM30\n"},
    {"an alarm behind settled blocks", "fanuc-0i-m", "{}",
     "G90 G94 G01 G41 X10. D1 F100\nX30.\nX30.3 Y.3\nY40.\nX60.\nG40 X80.\nM30\n"},
    {"chamfers before compensation", "k2000tc", "{}",
     "T0101\nG98 G42 G01 X20. Z-10. F100\nZ-30. NR3.\nX60. NC2.\nZ-50.\nG40 X80.\nM30\n"},
    {"hole cycles", "fanuc-0i-m", "{}",
     "G90 G94 G00 Z20. S500 M03\nG98 G83 X1. Z-10. R2. Q3. F100\nX2. K2\nG80\nG00 X0\nM30\n"},
    {"boxes and threads", "gsk-218t", "{}",
     "T0101\nG0 X70 Z10 F100 S100 M3\nG90 X60 Z-30\nX50\nG92 X48 Z-20 F2\nX47\nG0 X100\nM30\n"},
};

TEST(StreamedCompensation, ByteByByteIsTheSameAsTheWhole) {
  for (const Case& one : kCases) {
    SCOPED_TRACE(one.name);
    const auto whole = run(one.profile, program::source_from_text(one.text), one.parameters);
    ASSERT_GT(whole.size(), 2u);
    for (const std::size_t piece : {1u, 2u, 5u, 13u}) {
      int waits = 0;
      EXPECT_EQ(run(one.profile, std::make_unique<Dripping>(one.text, piece), one.parameters, &waits), whole);
      EXPECT_GT(waits, 2);
    }
  }
}

// A roughing cycle must read its profile ahead and again: a drip-feed cannot be read back, and says so.
TEST(StreamedCompensation, AProfileThatCannotBeReadBackIsAnAlarm) {
  const std::string text =
      "G98 G00 X60. Z5. M03 S100\nG71 U5. R1.\nG71 P1 Q2 U0 W0 F100\nN1 G00 X20.\nN2 G01 Z-20.\nM30\n";
  const auto made = run("fanuc-0i-t", std::make_unique<Dripping>(text, 3), "{}");
  ASSERT_FALSE(made.empty());
  EXPECT_EQ(made.back().kind, Operation(Alarm{}).index());
  for (const Move& move : made) EXPECT_LE(move.line, 3u);
}

}  // namespace
}  // namespace headstock::interp
