#include "dialects/dialect.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "dialects/catalogue.hpp"
#include "machine/machine.hpp"

namespace headstock::dialects {
namespace {

TEST(Dialects, SixAndNoOther) {
  EXPECT_EQ(dialect_names().size(), 6u);
  for (const std::string_view name : dialect_names()) {
    const Dialect* dialect = find(name);
    ASSERT_NE(dialect, nullptr) << name;
    EXPECT_EQ(dialect->profile, name);
    EXPECT_TRUE(machine::default_machine(name)) << name;
  }
  EXPECT_EQ(find("fanuc-0i"), nullptr);
  EXPECT_EQ(find(""), nullptr);
}

TEST(Dialects, EveryAlarmNumberIsInTheCatalogue) {
  for (const std::string_view name : dialect_names()) {
    for (std::size_t reason = 0; reason < kAlarmReasons; ++reason) {
      const std::string_view code = find(name)->alarm_codes[reason];
      ASSERT_FALSE(code.empty()) << name << " reason " << reason;
      Alarm row;
      if (code == "HS0001") continue;
      // Numbers of the scheme K2000TCi follows; its manual, and so its catalogue, does not list them.
      static const std::set<std::string_view> kUnlisted = {"PS0004", "PS0005", "PS0006", "PS0021",
                                                           "PS0030", "PS0086", "PS0114"};
      if (name == "k2000tc" && kUnlisted.count(code) != 0) continue;
      EXPECT_TRUE(find_alarm(name, code, row)) << name << ' ' << code;
    }
  }
}

TEST(Dialects, EverySystemHasItsMotionAndOnePowerOnCodeAGroup) {
  for (const std::string_view name : dialect_names()) {
    for (const char system : {'A', 'B', 'C'}) {
      const GTable& table = find(name)->table(system);
      for (const std::int32_t motion : {0, 10, 20, 30}) {
        ASSERT_NE(table.find(motion), nullptr) << name;
        EXPECT_EQ(table.find(motion)->phase, Phase::motion) << name;
        EXPECT_EQ(table.find(motion)->group, 1) << name;
      }
      std::uint32_t groups = 0;
      for (const GCode& code : table.rows()) {
        if (code.phase != Phase::unavailable && code.phase != Phase::setting &&
            code.phase != Phase::modifier) {
          EXPECT_NE(code.handler, nullptr) << name << ' ' << code.name;
        }
        if (!code.power_on) continue;
        EXPECT_EQ(groups & (1u << code.group), 0u)
            << name << ' ' << system << " two power-on codes: " << code.name;
        groups |= 1u << code.group;
      }
      EXPECT_NE(groups & 2u, 0u) << name << ": no motion code at power-on";
      EXPECT_EQ(table.find(-1), nullptr);
      EXPECT_EQ(table.find(10'000), nullptr);
    }
  }
}

TEST(Dialects, SystemsOfTheFanucLathe) {
  const Dialect* dialect = find("fanuc-0i-t");
  EXPECT_EQ(dialect->table('A').find(320)->name, "G32");
  EXPECT_EQ(dialect->table('A').find(330), nullptr);
  EXPECT_EQ(dialect->table('B').find(330)->name, "G33");
  EXPECT_EQ(dialect->table('A').find(900)->phase, Phase::motion);   // turning cycle
  EXPECT_EQ(dialect->table('B').find(900)->phase, Phase::setting);      // absolute
  EXPECT_EQ(dialect->table('C').find(700)->group, 6);                   // inch
}

}  // namespace
}  // namespace headstock::dialects
