// Programs thrown together from the words of K2000TC and 200T: every one ends, or is cut off, without a
// crash.
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "dialects/dialect.hpp"
#include "interpreter/interpreter.hpp"
#include "machine/machine.hpp"
#include "program/library.hpp"

namespace headstock {
namespace {

constexpr std::string_view kK2000[] = {"G00",
                                       "G01",
                                       "G02",
                                       "G03",
                                       "G02.1",
                                       "G03.2",
                                       "G02.3",
                                       "G03.4",
                                       "G02.5",
                                       "G04",
                                       "G05",
                                       "G07",
                                       "G07.2",
                                       "G10",
                                       "G10.9",
                                       "G16",
                                       "G15",
                                       "G17",
                                       "G18",
                                       "G19",
                                       "G20",
                                       "G21",
                                       "G28",
                                       "G29",
                                       "G30",
                                       "G31",
                                       "G32",
                                       "G34",
                                       "G50",
                                       "G51",
                                       "G52",
                                       "G53",
                                       "G153",
                                       "G54.9",
                                       "G55",
                                       "G65",
                                       "G68.1",
                                       "G69.1",
                                       "G68",
                                       "G69",
                                       "G90",
                                       "G91",
                                       "G96",
                                       "G12.1",
                                       "G13.1",
                                       "G07.1",
                                       "X10.",
                                       "X-5.",
                                       "U3.",
                                       "Z20.",
                                       "W-1.",
                                       "Y7.",
                                       "C90.",
                                       "H45.",
                                       "I5.",
                                       "J-5.",
                                       "K2.",
                                       "R8.",
                                       "R-8.",
                                       "Q720.",
                                       "P1",
                                       "P2",
                                       "P14",
                                       "P142",
                                       "P24",
                                       "F100.",
                                       "S500",
                                       "T0101",
                                       "M03",
                                       "M05",
                                       "M98",
                                       "M99",
                                       "M91",
                                       "M06",
                                       "NX1.",
                                       "NY1.",
                                       "NZ1.",
                                       "NF5.",
                                       "NI1.",
                                       "NA30.",
                                       ",C1.",
                                       "CT11",
                                       "AD80.",
                                       "#1=5",
                                       "#2+=#1",
                                       "#1=NULL",
                                       "r3=[1+2]*3",
                                       "#100[#1]=4",
                                       "IF[#1<5] GOTO 10",
                                       "GOTO 20",
                                       "WHILE[#1<9] DO 1",
                                       "END 1",
                                       "DO 2",
                                       "END 2",
                                       "CALL[1, #1, 2.5]",
                                       "PARAMS[r1,r2]",
                                       "MSG[\"a\",#1]",
                                       "ERR[5]",
                                       "X#1",
                                       "X[#1*2]",
                                       "Z-#1",
                                       "G[#4002]",
                                       "#5041",
                                       "N10",
                                       "N20",
                                       "/",
                                       "(",
                                       ")",
                                       "\"",
                                       "[",
                                       "]",
                                       "{",
                                       "}",
                                       "%",
                                       "O1",
                                       "=",
                                       "-",
                                       "&&",
                                       "1.5e3",
                                       "0x1F",
                                       "POW[2,3]",
                                       ";"};

constexpr std::string_view kLathe[] = {"G00",
                                       "G01",
                                       "G02",
                                       "G03",
                                       "G04",
                                       "G10",
                                       "G26",
                                       "G27",
                                       "G28",
                                       "G29",
                                       "G31",
                                       "G32",
                                       "G34",
                                       "G50",
                                       "G52",
                                       "G53",
                                       "G58",
                                       "G59",
                                       "G60",
                                       "G65 H01 P#200 Q5",
                                       "G65 H02 P#200 Q#200 R1",
                                       "G65 H84 P0010 Q#200 R9",
                                       "G65 H80 P0020",
                                       "G160",
                                       "G161",
                                       "G170 P0010 Q0020",
                                       "G171 P0010 Q0020 L2",
                                       "X10",
                                       "X-5",
                                       "U3",
                                       "Z20",
                                       "W-1",
                                       "I5",
                                       "K-2",
                                       "R8",
                                       "P1",
                                       "P01",
                                       "L31",
                                       "H01",
                                       "H03",
                                       "F100",
                                       "S2",
                                       "S600",
                                       "T1",
                                       "T0203",
                                       "M03",
                                       "M01",
                                       "M26.150",
                                       "M1026.150",
                                       "M-2127.200",
                                       "M98 NSUB",
                                       "M98 NT11 P3",
                                       "M99",
                                       "M96",
                                       "N0010",
                                       "N0020",
                                       "X#200",
                                       "X-#201",
                                       "F##200",
                                       "#31",
                                       "(",
                                       ")",
                                       ";",
                                       "/",
                                       "%",
                                       "M",
                                       "G",
                                       "."};

template <std::size_t n>
std::string program(std::mt19937& random, const std::string_view (&words)[n]) {
  // Half of the programs are without the loose characters at the end of the list.
  std::uniform_int_distribution<std::size_t> word(0, random() % 2 == 0 ? n - 1 : n - 19), lines(1, 25),
      length(1, 3);
  std::string text;
  for (std::size_t line = lines(random); line > 0; --line) {
    for (std::size_t i = length(random); i > 0; --i) {
      text += words[word(random)];
      if (random() % 4 != 0) text += ' ';
    }
    text += '\n';
  }
  return text;
}

class Calls final : public program::Programs {
 public:
  explicit Calls(std::string text) : text_(std::move(text)) {}
  std::unique_ptr<program::Source> open_number(std::uint32_t) override {
    return program::source_from_text(text_);
  }
  std::unique_ptr<program::Source> open_name(std::string_view) override {
    return program::source_from_text(text_);
  }

 private:
  std::string text_;
};

template <std::size_t n>
void run(const char* profile, const std::string_view (&words)[n], char system) {
  machine::Machine machine = *machine::default_machine(profile);
  if (std::string_view(profile) == "k2000tc") {
    for (const char name : {'Y', 'C'}) {
      machine::Axis axis;
      axis.name = name;
      axis.rotary = name == 'C';
      machine.axes.push_back(axis);
    }
  }
  std::mt19937 random(7);
  for (int i = 0; i < 20'000; ++i) {
    const std::string text = program(random, words);
    Calls calls(program(random, words));
    interp::MachineData data;
    if (i % 3 == 0) data.parameters["P4100.5"] = 0;
    interp::Interpreter interpreter(*dialects::find(profile), machine, data, &calls);
    interp::Switches switches;
    switches.gcode_system = system;
    switches.lenient = i % 5 == 0;
    interpreter.set_switches(switches);
    interpreter.start(program::source_from_text(text), {});
    interp::Operation operation;
    int made = 0;
    while (made < 3'000 && interpreter.next(operation) == interp::Pull::operation) ++made;
    interpreter.reset({});
    EXPECT_EQ(interpreter.next(operation), interp::Pull::finished) << text;
  }
}

TEST(RandomText, K2000tcEnds) {
  run("k2000tc", kK2000, 'A');
  run("k2000tc", kK2000, 'B');
}

TEST(RandomText, Lathe200tEnds) {
  run("lathe-200t", kLathe, 'A');
}

}  // namespace
}  // namespace headstock
