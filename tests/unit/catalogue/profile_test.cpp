// `headstock profile` as a person or a script runs it.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

namespace {

struct Printed {
  std::string out;
  int status = -1;
};

Printed profile(const std::string& arguments) {
  Printed run;
  FILE* pipe =
      popen((HEADSTOCK_BINARY_DIR "/bin/headstock profile " + arguments + " 2>/dev/null").c_str(), "r");
  if (pipe == nullptr) return run;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
    run.out.append(buffer.data(), n);
  run.status = WEXITSTATUS(pclose(pipe));
  return run;
}

TEST(Profile, ListsAlarmsAsJsonInBothLanguages) {
  const Printed run = profile("fanuc-0i-m --alarms --json");
  ASSERT_EQ(run.status, 0);
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["profile"], "fanuc-0i-m");
  bool found = false;
  for (const auto& alarm : json["alarms"]) {
    if (alarm["code"] != "PS0010") continue;
    found = true;
    EXPECT_EQ(alarm["en"], "Improper G code");
    EXPECT_EQ(alarm["zh"], "G 代码不正确");
  }
  EXPECT_TRUE(found);
}

TEST(Profile, CoverageOfEveryProfileAddsUp) {
  for (const char* name : {"fanuc-0i-t", "fanuc-0i-m", "gsk-2000tc", "gsk-218t", "k2000tc", "lathe-200t"}) {
    const Printed run = profile(std::string(name) + " --coverage --json");
    ASSERT_EQ(run.status, 0) << name;
    const auto coverage = nlohmann::json::parse(run.out)["coverage"];
    for (const char* kind : {"gcodes", "mcodes", "alarms", "parameters", "variables"}) {
      const auto& part = coverage[kind];
      EXPECT_EQ(part["done"].size() + part["off_panel"].size() + part["missing"].size(),
                part["counts"]["total"].get<std::size_t>())
          << name << " " << kind;
      for (const auto& row : part["off_panel"]) EXPECT_FALSE(row["reason"].get<std::string>().empty()) << name;
    }
    EXPECT_GT(coverage["alarms"]["done"].size(), 5u) << name;
  }
}

TEST(Profile, TextHasOneRowALine) {
  const Printed run = profile("gsk-218t --alarms");
  ASSERT_EQ(run.status, 0);
  EXPECT_NE(run.out.find("010\tIllegal G code\tG 代码无效\n"), std::string::npos);
}

TEST(Profile, AnUnknownProfileIsBadUsage) {
  EXPECT_EQ(profile("fanuc-31i --alarms").status, 1);
  EXPECT_EQ(profile("").status, 1);
}

}  // namespace
