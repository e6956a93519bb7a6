#include "protocol/process/options.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

namespace headstock::options {
namespace {

struct Ending {
  std::optional<int> status;
  std::string out, err;
};

/// Reads WORDS as the command line of a program named "tool".
Ending read(Program& program, std::vector<const char*> words) {
  words.insert(words.begin(), "tool");
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  Ending ending;
  ending.status = program.parse(static_cast<int>(words.size()), words.data(), 7);
  ending.err = ::testing::internal::GetCapturedStderr();
  ending.out = ::testing::internal::GetCapturedStdout();
  return ending;
}

/// What stands on stderr when one option, described by DESCRIBE, is given WORDS; empty when they are taken.
template <class Value, class Describe>
std::string refused(Value& value, const std::vector<const char*>& words, Describe describe) {
  Program program("About", "tool");
  describe(program.option("--it", value, "Help"));
  const Ending ending = read(program, words);
  EXPECT_EQ(ending.status.value_or(0), ending.err.empty() ? 0 : 7);
  EXPECT_EQ(ending.out, "");
  return ending.err;
}
template <class Value>
std::string refused(Value& value, const std::vector<const char*>& words) {
  return refused(value, words, [](Option) {});
}

std::string said(const std::string& line) {
  return line + "\nRun with --help for more information.\n";
}

TEST(Options, FillWhatTheyAreBoundTo) {
  std::string text;
  EXPECT_EQ(refused(text, {"--it", "O1001 (SHAFT)"}), "");
  EXPECT_EQ(text, "O1001 (SHAFT)");
  std::filesystem::path path;
  EXPECT_EQ(refused(path, {"--it=/var/lib/shop"}), "");
  EXPECT_EQ(path, "/var/lib/shop");
  int number = 0;
  EXPECT_EQ(refused(number, {"--it", "-12"}), "");
  EXPECT_EQ(number, -12);
  std::int64_t large = 0;
  EXPECT_EQ(refused(large, {"--it", "9007199254740993"}), "");
  EXPECT_EQ(large, 9007199254740993);
  std::uint16_t port = 0;
  EXPECT_EQ(refused(port, {"--it", "65535"}), "");
  EXPECT_EQ(port, 65'535);
  std::uint64_t bytes = 0;
  EXPECT_EQ(refused(bytes, {"--it", "18446744073709551615"}), "");
  EXPECT_EQ(bytes, std::numeric_limits<std::uint64_t>::max());
  double factor = 0;
  EXPECT_EQ(refused(factor, {"--it", "0.25"}), "");
  EXPECT_EQ(factor, 0.25);
  std::vector<std::string> several;
  EXPECT_EQ(refused(several, {"--it", "a", "b", "--it", "c"}), "");
  EXPECT_EQ(several, (std::vector<std::string>{"a", "b", "c"}));
  std::optional<std::uint32_t> limit;
  EXPECT_EQ(refused(limit, {}), "");
  EXPECT_EQ(limit, std::nullopt);
  EXPECT_EQ(refused(limit, {"--it", "0"}), "");
  EXPECT_EQ(limit, 0U);
}

TEST(Options, LeaveWhatIsNotGivenAsItWas) {
  int number = 42;
  EXPECT_EQ(refused(number, {}), "");
  EXPECT_EQ(number, 42);
}

TEST(Options, RefuseWhatTheirTypeCannotHold) {
  int number = 0;
  EXPECT_EQ(refused(number, {"--it", "3.5"}), said("Could not convert: --it = 3.5"));
  EXPECT_EQ(refused(number, {"--it", "99999999999"}), said("Could not convert: --it = 99999999999"));
  std::uint16_t port = 0;
  EXPECT_EQ(refused(port, {"--it", "65536"}), said("Could not convert: --it = 65536"));
  EXPECT_EQ(refused(port, {"--it", "-1"}), said("Could not convert: --it = -1"));
  std::uint32_t count = 0;
  EXPECT_EQ(refused(count, {"--it", "many"}), said("Could not convert: --it = many"));
  std::string text;
  EXPECT_EQ(refused(text, {"--it"}), said("--it: 1 required TEXT missing"));
  EXPECT_EQ(refused(text, {"--its", "x"}), said("The following arguments were not expected: x --its"));
}

TEST(Options, RefuseWhatTheirDescriptionForbids) {
  int number = 5;
  EXPECT_EQ(refused(number, {}, [](Option it) { it.required(); }), said("--it is required"));
  const auto positive = [](Option it) { it.positive(); };
  EXPECT_EQ(refused(number, {"--it", "1"}, positive), "");
  EXPECT_NE(refused(number, {"--it", "0"}, positive), "");
  const auto not_negative = [](Option it) { it.not_negative(); };
  EXPECT_EQ(refused(number, {"--it", "0"}, not_negative), "");
  EXPECT_NE(refused(number, {"--it", "-1"}, not_negative), "");
  const auto whole = [](Option it) { it.between(3, 4'096); };
  EXPECT_EQ(refused(number, {"--it", "3"}, whole), "");
  EXPECT_EQ(refused(number, {"--it", "4096"}, whole), "");
  EXPECT_EQ(refused(number, {"--it", "2"}, whole), said("--it: Value 2 not in range 3 to 4096"));
  EXPECT_EQ(refused(number, {"--it", "4097"}, whole), said("--it: Value 4097 not in range 3 to 4096"));
  double factor = 0;
  const auto real = [](Option it) { it.between(0.5, 2.0); };
  EXPECT_EQ(refused(factor, {"--it", "0.5"}, real), "");
  EXPECT_NE(refused(factor, {"--it", "0.49"}, real), "");
  std::string text;
  const auto words = [](Option it) { it.one_of({"en", "zh"}); };
  EXPECT_EQ(refused(text, {"--it", "zh"}, words), "");
  EXPECT_EQ(text, "zh");
  EXPECT_EQ(refused(text, {"--it", "fr"}, words), said("--it: fr not in {en,zh}"));
  const auto file = [](Option it) { it.existing_file(); };
  EXPECT_EQ(refused(text, {"--it", __FILE__}, file), "");
  EXPECT_EQ(refused(text, {"--it", "/no/such/file"}, file), said("--it: File does not exist: /no/such/file"));
}

TEST(Options, DependOnEachOther) {
  bool page = false, coverage = false, json = false;
  const auto tell = [&](std::vector<const char*> words) {
    Program program("About", "tool");
    program.flag("--coverage", coverage);
    program.flag("--page", page).needs("--coverage");
    program.flag("--json", json).excludes("--page");
    return read(program, std::move(words)).err;
  };
  EXPECT_EQ(tell({"--page", "--coverage"}), "");
  EXPECT_TRUE(page && coverage && !json);
  EXPECT_EQ(tell({"--page"}), said("--page requires --coverage"));
  EXPECT_EQ(tell({"--page", "--coverage", "--json"}), said("--page excludes --json"));
}

TEST(Options, ADefectiveDescriptionIsNoticedAtOnce) {
  bool flag = false;
  Program program("About", "tool");
  program.flag("--page", flag);
  EXPECT_ANY_THROW(program.flag("--page", flag));
  EXPECT_ANY_THROW(program.flag("--json", flag).needs("--coverage"));
}

TEST(Options, ComeFromTheEnvironmentUnlessGiven) {
  ::setenv("HEADSTOCK_OPTIONS_TEST", "from the environment", 1);
  std::string text;
  const auto named = [](Option it) { it.environment("HEADSTOCK_OPTIONS_TEST"); };
  EXPECT_EQ(refused(text, {}, named), "");
  EXPECT_EQ(text, "from the environment");
  EXPECT_EQ(refused(text, {"--it", "given"}, named), "");
  EXPECT_EQ(text, "given");
  ::unsetenv("HEADSTOCK_OPTIONS_TEST");
}

TEST(Options, ExplainThemselves) {
  Program program("What it is", "tool");
  std::uint16_t port = 8080;
  std::string language;
  std::vector<std::string> files;
  bool quick = false;
  program.option("--port", port, "Where").shows_default();
  program.option("--lang", language, "Words").one_of({"en", "zh"});
  program.option("-o,--output", language, "Target").required();
  program.flag("--quick", quick, "Less");
  program.option("FILE", files, "Sources");
  program.add_command("go", "Do it");
  program.footer("Below");
  program.version("tool 1.2");
  const Ending help = read(program, {"--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_EQ(help.err, "");
  for (const char* part : {"What it is\n", "Usage: tool [OPTIONS] [FILE...] [SUBCOMMAND]\n",
                           "--port UINT=8080", "--lang TEXT:{en,zh}", "-o,--output TEXT REQUIRED", "--quick ",
                           "FILE TEXT ...", "  go ", "Do it", "\nBelow\n"})
    EXPECT_NE(help.out.find(part), std::string::npos) << part << "\n" << help.out;
  const Ending version = read(program, {"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_EQ(version.out, "tool 1.2\n");
}

TEST(Commands, RunWhenTheWholeLineIsRight) {
  std::string ran;
  std::string name;
  bool json = false;
  const auto run = [&](std::vector<const char*> words) {
    ran.clear();
    Program program("About", "tool");
    program.flag("--json", json);
    program.shares_options();
    program.requires_command();
    auto users = program.add_command("users", "Users");
    users.allows_command();
    auto add = users.add_command("add", "One more");
    add.option("NAME", name).required();
    add.callback([&ran, &name] { ran += "add " + name + " "; });
    users.callback([&ran, users, add] { ran += users.alone() ? "list" : add.called() ? "users" : "?"; });
    return read(program, std::move(words));
  };
  EXPECT_EQ(run({"users"}).status, std::nullopt);
  EXPECT_EQ(ran, "list");
  EXPECT_EQ(run({"users", "add", "wang", "--json"}).status, std::nullopt);
  EXPECT_EQ(ran, "add wang users");
  EXPECT_TRUE(json);
  EXPECT_EQ(run({}).err, said("A subcommand is required"));
  EXPECT_EQ(run({"users", "add"}).err, said("NAME is required"));
  EXPECT_EQ(run({"users", "add", "wang", "--bad"}).err,
            said("The following argument was not expected: --bad"));
  EXPECT_EQ(run({"others"}).status, 7);
  EXPECT_EQ(ran, "");
}

TEST(Commands, TellWhatOnlyTheProgramCanJudge) {
  Program program("About", "tool");
  program.callback([] { throw Refusal("--server", "takes HOST:PORT, not 'x'"); });
  const Ending wrong = read(program, {});
  EXPECT_EQ(wrong.status, 7);
  EXPECT_EQ(wrong.err, said("--server: takes HOST:PORT, not 'x'"));
  EXPECT_STREQ(Refusal::missing("--data").what(), "--data is required");
}

}  // namespace
}  // namespace headstock::options
