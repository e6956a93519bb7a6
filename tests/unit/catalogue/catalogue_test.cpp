#include "dialects/catalogue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "dialects/dialect.hpp"

namespace headstock::dialects {
namespace {

// Length of the UTF-8 text in code points, -1 when it is not valid.
int utf8_length(std::string_view text) {
  int count = 0;
  for (std::size_t i = 0; i < text.size(); ++count) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const std::size_t bytes = lead < 0x80                   ? 1
                              : lead >= 0xf0 && lead < 0xf5 ? 4
                              : lead >= 0xe0                ? 3
                              : lead >= 0xc2                ? 2
                                                            : 0;
    if (bytes == 0 || i + bytes > text.size() || lead >= 0xf5) return -1;
    for (std::size_t k = 1; k < bytes; ++k)
      if ((static_cast<unsigned char>(text[i + k]) & 0xc0) != 0x80) return -1;
    i += bytes;
  }
  return count;
}

bool has_chinese(std::string_view text) {
  for (std::size_t i = 0; i + 2 < text.size(); ++i) {
    const auto lead = static_cast<unsigned char>(text[i]);
    if (lead >= 0xe4 && lead <= 0xe9) return true;  // U+4000 … U+9FFF
  }
  return false;
}

void expect_clean(std::string_view profile, std::string_view key,
                  std::initializer_list<std::string_view> cells) {
  for (const auto cell : cells) {
    EXPECT_GE(utf8_length(cell), 0) << profile << " " << key << ": not UTF-8";
    EXPECT_EQ(cell.find_first_of("\r\n\t"), std::string_view::npos) << profile << " " << key;
    if (cell.empty()) continue;
    EXPECT_NE(cell.front(), ' ') << profile << " " << key;
    EXPECT_NE(cell.back(), ' ') << profile << " " << key;
  }
}

TEST(Catalogue, SixProfiles) {
  EXPECT_THAT(profiles(), ::testing::ElementsAre("fanuc-0i-t", "fanuc-0i-m", "gsk-2000tc", "gsk-218t",
                                                 "k2000tc", "lathe-200t"));
  EXPECT_TRUE(alarms("fanuc-0i").empty());
  EXPECT_TRUE(parameters("").empty());
}

TEST(Catalogue, EveryAlarmHasANumberAndBothLanguages) {
  for (const auto profile : profiles()) {
    std::set<std::string_view> codes;
    for (const Alarm& alarm : alarms(profile)) {
      EXPECT_TRUE(codes.insert(alarm.code).second) << profile << " " << alarm.code << " twice";
      EXPECT_FALSE(alarm.code.empty());
      EXPECT_FALSE(alarm.en.empty()) << profile << " " << alarm.code;
      EXPECT_FALSE(has_chinese(alarm.en)) << profile << " " << alarm.code;
      EXPECT_TRUE(has_chinese(alarm.zh)) << profile << " " << alarm.code;
      EXPECT_LE(utf8_length(alarm.en), 64) << profile << " " << alarm.code << ": longer than a message line";
      EXPECT_LE(utf8_length(alarm.zh), 32) << profile << " " << alarm.code << ": longer than a message line";
      expect_clean(profile, alarm.code,
                   {alarm.code, alarm.en, alarm.zh, alarm.cause, alarm.cleared_by, alarm.source});
    }
    EXPECT_FALSE(codes.empty()) << profile;
  }
}

// alarm_numbers.txt: `[controller]`, then its numbers.
TEST(Catalogue, EveryAlarmOfTheManualsIsThere) {
  const std::map<std::string, std::vector<std::string_view>> profiles_of = {
      {"fanuc-0i", {"fanuc-0i-t", "fanuc-0i-m"}},
      {"gsk-2000tc", {"gsk-2000tc"}},
      {"gsk-218t", {"gsk-218t"}},
      {"k2000tc", {"k2000tc"}},
      {"lathe-200t", {"lathe-200t"}}};
  std::ifstream in(HEADSTOCK_SOURCE_DIR "/tests/unit/catalogue/alarm_numbers.txt");
  ASSERT_TRUE(in);
  std::string line, controller;
  int checked = 0;
  while (std::getline(in, line)) {
    if (line.starts_with('#')) continue;
    if (line.starts_with('[')) {
      controller = line.substr(1, line.size() - 2);
      continue;
    }
    std::istringstream words(line);
    for (std::string code; words >> code; ++checked) {
      bool known = false;
      for (const auto profile : profiles_of.at(controller)) {
        Alarm alarm;
        known = known || find_alarm(profile, code, alarm);
      }
      EXPECT_TRUE(known) << controller << " " << code;
    }
  }
  EXPECT_GT(checked, 980);
}

TEST(Catalogue, TheScreenTextsOfWellKnownAlarms) {
  struct Known {
    std::string_view profile, code, en, zh;
  };
  const Known known[] = {
      {"fanuc-0i-m", "PS0010", "Improper G code", "G 代码不正确"},
      {"fanuc-0i-t", "OT0500", "+ overtravel (soft 1)", "正向超程（软限位 1）"},
      {"gsk-218t", "010", "Illegal G code", "G 代码无效"},
      {"gsk-2000tc", "201", "X+ soft limit", "X 轴正向软限位超程"},
      {"k2000tc", "PS0041", "Interference in radius compensation", "刀尖半径补偿干涉（过切）"},
      {"lathe-200t", "A11", "Emergency stop pressed", "急停按下"},
  };
  for (const auto& expected : known) {
    const Alarm alarm = alarm_text(expected.profile, expected.code);
    EXPECT_EQ(alarm.en, expected.en);
    EXPECT_EQ(alarm.zh, expected.zh);
  }
}

TEST(Catalogue, EveryAlarmThatADialectRaisesHasItsText) {
  for (const auto profile : profiles()) {
    const Dialect* dialect = find(profile);
    ASSERT_NE(dialect, nullptr) << profile;
    for (std::size_t reason = 0; reason < dialect->alarm_codes.size(); ++reason) {
      const auto code = dialect->alarm_codes[reason];
      EXPECT_NE(alarm_text(profile, code).en, code) << profile << " reason " << reason;
    }
  }
}

TEST(Catalogue, UserAlarmsAreFoundByAnyNumberOfTheirRange) {
  Alarm alarm;
  EXPECT_TRUE(find_alarm("gsk-2000tc", "3015", alarm));
  EXPECT_EQ(alarm.code, "3000-3999");
  EXPECT_TRUE(find_alarm("gsk-218t", "415", alarm));
  EXPECT_TRUE(find_alarm("k2000tc", "PS3005", alarm));
  EXPECT_FALSE(find_alarm("k2000tc", "3005", alarm));
  EXPECT_FALSE(find_alarm("gsk-2000tc", "4000", alarm));
  EXPECT_EQ(alarm_text("gsk-218t", "415").code, "415") << "shown with the number that was raised";
}

TEST(Catalogue, AnUnknownAlarmIsShownByItsNumber) {
  EXPECT_EQ(alarm_text("fanuc-0i-t", "PS9999").en, "PS9999");
  EXPECT_EQ(alarm_text("fanuc-0i-t", "PS9999").zh, "PS9999");
  EXPECT_EQ(alarm_text("nothing", "PS0010").en, "PS0010");
}

TEST(Catalogue, ASeriesHasOnlyItsOwnRows) {
  Alarm alarm;
  for (const Alarm& row : alarms("fanuc-0i-t")) EXPECT_NE(row.series, "M") << row.code;
  for (const Alarm& row : alarms("fanuc-0i-m")) EXPECT_NE(row.series, "T") << row.code;
  EXPECT_TRUE(find_alarm("fanuc-0i-t", "PS0061", alarm)) << "turning cycles";
  EXPECT_FALSE(find_alarm("fanuc-0i-m", "PS0061", alarm));
  EXPECT_EQ(alarm_text("fanuc-0i-m", "PS0061").en, alarm.en) << "still better than a bare number";
}

TEST(Catalogue, ParametersAreUniqueAndSayWhatTheyAre) {
  for (const auto profile : profiles()) {
    std::set<std::string_view> numbers;
    for (const Parameter& parameter : parameters(profile)) {
      EXPECT_TRUE(numbers.insert(parameter.number).second) << profile << " " << parameter.number << " twice";
      EXPECT_FALSE(parameter.number.empty());
      EXPECT_FALSE(parameter.meaning.empty()) << profile << " " << parameter.number;
      EXPECT_TRUE(has_chinese(parameter.name_zh)) << profile << " " << parameter.number;
      expect_clean(profile, parameter.number,
                   {parameter.number, parameter.symbol, parameter.name_zh, parameter.meaning, parameter.unit,
                    parameter.range, parameter.default_value, parameter.effective, parameter.source});
      Parameter found;
      EXPECT_TRUE(find_parameter(profile, parameter.number, found));
      EXPECT_EQ(found.meaning, parameter.meaning);
    }
    EXPECT_GT(numbers.size(), 60u) << profile;
  }
  Parameter found;
  ASSERT_TRUE(find_parameter("fanuc-0i-m", "3402#0", found));
  EXPECT_EQ(found.symbol, "G01");
  EXPECT_EQ(found.default_value, "0");
  EXPECT_FALSE(find_parameter("fanuc-0i-m", "99999", found));
}

TEST(Catalogue, MCodesSignalsAndVariablesAreWellFormed) {
  for (const auto profile : profiles()) {
    std::set<std::string_view> codes;
    for (const MCode& row : mcodes(profile)) {
      EXPECT_TRUE(codes.insert(row.code).second) << profile << " " << row.code << " twice";
      EXPECT_FALSE(row.meaning.empty()) << profile << " " << row.code;
      expect_clean(profile, row.code, {row.code, row.meaning, row.source});
    }
    EXPECT_TRUE(codes.contains("M30")) << profile;
    std::set<std::string> places;
    for (const Signal& row : signals(profile)) {
      EXPECT_TRUE(places.insert(std::string(row.address) + " " + std::string(row.symbol)).second)
          << profile << " " << row.address << row.symbol;
      EXPECT_FALSE(row.address.empty() && row.symbol.empty()) << profile << row.meaning;
      EXPECT_FALSE(row.meaning.empty()) << profile << " " << row.address << row.symbol;
      expect_clean(profile, row.address, {row.address, row.symbol, row.direction, row.meaning, row.source});
    }
    std::set<std::string_view> numbers;
    for (const Variable& row : variables(profile)) {
      EXPECT_TRUE(numbers.insert(row.number).second) << profile << " " << row.number << " twice";
      EXPECT_FALSE(row.meaning.empty()) << profile << " " << row.number;
      expect_clean(profile, row.number, {row.number, row.access, row.meaning, row.source});
    }
    EXPECT_FALSE(places.empty()) << profile;
    EXPECT_FALSE(numbers.empty()) << profile;
  }
}

}  // namespace
}  // namespace headstock::dialects
