// What the cases show: every worked example of the manuals has its row in examples.tsv, and what the row
// names exists; every alarm that the language can raise has a misuse case of its profile.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "command-line/offline/coverage.hpp"
#include "dialects/dialect.hpp"

namespace headstock::conformance {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = HEADSTOCK_SOURCE_DIR;
const fs::path kCases = kRoot / "tests/conformance/cases";

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> split(const std::string& text, const std::string& by) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(by, from), text.size());
    parts.push_back(text.substr(from, to - from));
    from = to + by.size();
  }
  return parts;
}

// Rows of a table with a header line; lines that begin with # are for people.
std::vector<std::vector<std::string>> rows_of(const char* name, std::size_t columns) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text_of(kRoot / "tests/conformance" / name));
  bool header = true;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    if (std::exchange(header, false)) continue;
    rows.push_back(split(line, "\t"));
    EXPECT_EQ(rows.back().size(), columns) << name << ": " << line;
    rows.back().resize(columns);
  }
  return rows;
}

// "PROFILE/CASE" is a case; "FILE TestName" a test of that file; "FILE" all of it.
std::string not_there(const std::string& shown) {
  const std::size_t blank = shown.find(' ');
  const std::string file = shown.substr(0, blank);
  if (fs::exists(kCases / (file + ".case"))) return {};
  if (file.find('.') == file.npos || !fs::is_regular_file(kRoot / file))
    return "no such case or file: " + file;
  if (blank == shown.npos) return {};
  const std::string test = shown.substr(blank + 1);
  return text_of(kRoot / file).find(test) != std::string::npos ? std::string() : file + " has no " + test;
}

// Examples that the manuals' digests number, E1 to this one.
const std::map<std::string, int> kExamples = {
    {"fanuc-0i/a", 54},  {"fanuc-0i/b", 46}, {"fanuc-0i/c1", 32}, {"fanuc-0i/c2", 21}, {"fanuc-0i/d1", 27},
    {"fanuc-0i/d2", 21}, {"gsk-2000tc", 46}, {"gsk-218t", 60},    {"k2000tc", 178},    {"lathe-200t", 41}};

TEST(Ledger, EveryWorkedExampleIsShownOrSaysWhyNot) {
  std::map<std::string, std::set<std::string>> seen;
  for (const auto& row : rows_of("examples.tsv", 5)) {
    const std::string name = row[0] + " " + row[1];
    EXPECT_TRUE(seen[row[0]].insert(row[1]).second) << name << " twice";
    EXPECT_TRUE(kExamples.contains(row[0])) << name;
    if (row[3] == "-") {
      EXPECT_GT(row[4].size(), 10u) << name << " is not shown and has no reason";
      continue;
    }
    for (const std::string& shown : split(row[3], ", ")) EXPECT_EQ(not_there(shown), "") << name;
  }
  for (const auto& [manual, last] : kExamples)
    for (int number = 1; number <= last; ++number)
      EXPECT_TRUE(seen[manual].contains("E" + std::to_string(number))) << manual << " E" << number;
}

// The alarms that cases of this profile expect; both series of the 0i-D have one list of alarms.
std::set<std::string> expected_alarms(const std::string& profile) {
  std::set<std::string> alarms;
  for (const auto& entry : fs::recursive_directory_iterator(kCases)) {
    const std::string folder = entry.path().parent_path().filename().string();
    const bool sister = profile.starts_with("fanuc") && folder.starts_with("fanuc");
    if (entry.path().extension() != ".case" || (folder != profile && !sister)) continue;
    std::istringstream lines(text_of(entry.path()));
    for (std::string line; std::getline(lines, line);)
      if (line.starts_with("alarm ")) alarms.insert(split(line, " ")[1]);
  }
  return alarms;
}

// "PS3000-3999": any of them.
bool expects(const std::set<std::string>& alarms, const std::string& code) {
  const std::size_t dash = code.find('-');
  if (dash == code.npos) return alarms.contains(code);
  const std::size_t digits = code.find_first_of("0123456789");
  const int least = std::stoi(code.substr(digits, dash - digits)), most = std::stoi(code.substr(dash + 1));
  for (const std::string& one : alarms) {
    if (one.substr(0, digits) != code.substr(0, digits)) continue;
    const std::string number = one.substr(digits);
    if (number.empty() || number.find_first_not_of("0123456789") != number.npos) continue;
    if (std::stoi(number) >= least && std::stoi(number) <= most) return true;
  }
  return false;
}

TEST(Ledger, EveryAlarmOfTheLanguageHasItsMisuse) {
  std::map<std::string, std::string> elsewhere;  // "profile code" → what shows it
  for (const auto& row : rows_of("alarms-elsewhere.tsv", 4)) {
    for (const std::string& profile : split(row[0], ", "))
      for (const std::string& code : split(row[1], ", ")) elsewhere[profile + " " + code] = row[2];
    if (row[2] != "-") {
      EXPECT_EQ(not_there(row[2]), "") << row[1];
    } else {
      EXPECT_GT(row[3].size(), 10u) << row[1];
    }
  }
  for (const auto profile : dialects::dialect_names()) {
    const std::string name(profile);
    const std::set<std::string> alarms = expected_alarms(name);
    for (const auto& part : offline::coverage(profile)) {
      if (part.kind != "alarms") continue;
      for (const auto& item : part.items) {
        const std::string place(item.reason);
        const bool language = place == "interpreter" || place.starts_with("cycles/") ||
                              place.starts_with("dialects/") || place.find("interpreter/") != place.npos ||
                              place.find("dialects/") != place.npos;
        if (item.state != offline::State::done || !language) continue;
        const std::string code(item.code);
        if (!expects(alarms, code) && !elsewhere.contains(name + " " + code))
          ADD_FAILURE() << name << ' ' << code << " (" << item.name << "): no misuse case";
      }
    }
  }
}

}  // namespace
}  // namespace headstock::conformance
