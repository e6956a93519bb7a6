#include "link/program_memory.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "protocol/wire/digest.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace headstock::link {
namespace {

using testing_support::TemporaryFolder;
namespace fs = std::filesystem;

std::string read_all(program::Source& source) {
  std::string text;
  char buffer[7];
  for (;;) {
    const auto result = source.read(buffer);
    if (result.status != program::ReadStatus::data) return text;
    text.append(buffer, result.bytes);
  }
}

TEST(ProgramMemory, ProgramsStayOverRestartWithTheirHash) {
  const TemporaryFolder folder;
  std::int64_t since = 0;
  {
    ProgramMemory memory(folder.path(), 1000);
    EXPECT_TRUE(memory.put("O1001", "%\nO1001\nM30\n%\n").ok());
    since = memory.find("O1001")->since_ms;
  }
  ProgramMemory memory(folder.path(), 1000);
  const auto found = memory.find("O1001");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->sha256, wire::sha256_hex("%\nO1001\nM30\n%\n"));
  EXPECT_EQ(found->since_ms, since);
  EXPECT_EQ(memory.used_bytes(), 14u);
  EXPECT_EQ(read_all(*memory.open_name("O1001")), "%\nO1001\nM30\n%\n");
}

TEST(ProgramMemory, FindsProgramsAsAControlDoes) {
  const TemporaryFolder folder;
  ProgramMemory memory(folder.path(), 10000);
  memory.put("O0012.nc", "G0\n");
  memory.put("flange.NC", "%\n(FLANGE)\nO2000\nM30\n");
  memory.put("O7B", "O7\n");
  EXPECT_TRUE(memory.open_number(12));
  EXPECT_TRUE(memory.open_number(2000)) << "by the O word at its head";
  EXPECT_TRUE(memory.open_number(7)) << "the name is no number, the head is";
  EXPECT_FALSE(memory.open_number(13));
  EXPECT_TRUE(memory.open_name("FLANGE"));
  EXPECT_TRUE(memory.open_name("flange.nc"));
  EXPECT_FALSE(memory.open_name("flan"));
}

TEST(ProgramMemory, RefusesWhatDoesNotFit) {
  const TemporaryFolder folder;
  ProgramMemory memory(folder.path(), 100);
  EXPECT_TRUE(memory.put("A", std::string(60, 'a')).ok());
  EXPECT_EQ(memory.put("B", std::string(41, 'b')).reason, "memory_full");
  EXPECT_TRUE(memory.put("A", std::string(100, 'c')).ok()) << "the one it replaces does not count";
  EXPECT_EQ(memory.put("A", std::string(101, 'd')).reason, "memory_full");
  EXPECT_EQ(read_all(*memory.open_name("A")), std::string(100, 'c'));
}

TEST(ProgramMemory, RefusesNamesThatLeaveTheFolder) {
  const TemporaryFolder folder;
  ProgramMemory memory(folder.path(), 100);
  for (const char* name :
       {"", ".", "..", "../x", "a/b", "/etc/passwd", ".index.json", "a\nb", "a\\b", " a", "a ", "a:b", "a*"})
    EXPECT_EQ(memory.put(name, "x").reason, "bad_name") << name;
  EXPECT_EQ(memory.put(std::string("a\0b", 3), "x").reason, "bad_name");
  EXPECT_EQ(memory.put(std::string(65, 'a'), "x").reason, "bad_name");
  EXPECT_TRUE(memory.put("法兰 (1)-a+b_c.nc", "x").ok());
}

TEST(ProgramMemory, RunningProgramIsNeitherReplacedNorRemoved) {
  const TemporaryFolder folder;
  ProgramMemory memory(folder.path(), 100);
  memory.put("A", "old");
  memory.in_use([](const std::string& name) { return name == "A"; });
  EXPECT_EQ(memory.put("A", "new").reason, "running");
  EXPECT_EQ(memory.remove("A").reason, "running");
  EXPECT_TRUE(memory.put("A", "old").ok()) << "what is there already needs no replacing";
  EXPECT_EQ(read_all(*memory.open_name("A")), "old");
}

TEST(ProgramMemory, WhatIsBeingReadStaysWhatItWas) {
  const TemporaryFolder folder;
  ProgramMemory memory(folder.path(), 100);
  memory.put("A", "old text");
  const auto reading = memory.open_name("A");
  memory.put("A", "new text!");
  EXPECT_EQ(read_all(*reading), "old text");
  EXPECT_TRUE(reading->seek(4));
  EXPECT_EQ(read_all(*reading), "text");
}

TEST(ProgramMemory, CutPutGoesOnAfterRestart) {
  const TemporaryFolder folder;
  const std::string text(50'000, 'G');
  const std::string hash = wire::sha256_hex(text);
  MemoryResult result;
  {
    ProgramMemory memory(folder.path(), 100'000);
    const auto incoming = memory.begin_put("A", text.size(), hash, result);
    ASSERT_TRUE(incoming);
    EXPECT_TRUE(incoming->append(std::string_view(text).substr(0, 20'000)).ok());
    EXPECT_FALSE(memory.begin_put("A", text.size(), hash, result));
    EXPECT_EQ(result.reason, "busy");
    EXPECT_TRUE(memory.census().empty()) << "half a program is no program";
  }
  ProgramMemory memory(folder.path(), 100'000);
  const auto incoming = memory.begin_put("A", text.size(), hash, result);
  ASSERT_TRUE(incoming) << result.reason;
  EXPECT_EQ(incoming->offset(), 20'000u);
  EXPECT_EQ(incoming->prefix_sha256(), wire::sha256_hex(std::string_view(text).substr(0, 20'000)));
  EXPECT_TRUE(incoming->append(std::string_view(text).substr(20'000)).ok());
  EXPECT_TRUE(incoming->finish().ok());
  EXPECT_EQ(memory.find("A")->sha256, hash);
}

TEST(ProgramMemory, WrongBytesAreThrownAway) {
  const TemporaryFolder folder;
  ProgramMemory memory(folder.path(), 100);
  MemoryResult result;
  const std::string hash = wire::sha256_hex("right");
  {
    const auto incoming = memory.begin_put("A", 5, hash, result);
    EXPECT_TRUE(incoming->append("wrong").ok());
    EXPECT_EQ(incoming->append("x").reason, "bad_hash") << "more than was announced";
    EXPECT_EQ(incoming->finish().reason, "bad_hash");
  }
  EXPECT_EQ(memory.begin_put("A", 5, hash, result)->offset(), 0u);
  EXPECT_FALSE(memory.find("A"));
}

TEST(ProgramMemory, NoticesWhatWasChangedBehindItsBack) {
  const TemporaryFolder folder;
  {
    ProgramMemory memory(folder.path(), 100);
    memory.put("A", "one");
  }
  std::ofstream(folder.path() / "A") << "two, longer";
  std::ofstream(folder.path() / "B") << "copied in";
  fs::create_symlink("/etc/passwd", folder.path() / "C");
  ProgramMemory memory(folder.path(), 100);
  EXPECT_EQ(memory.find("A")->sha256, wire::sha256_hex("two, longer"));
  EXPECT_EQ(memory.find("B")->sha256, wire::sha256_hex("copied in"));
  EXPECT_FALSE(memory.find("C"));
}

TEST(ProgramMemory, CensusHashFollowsTheContent) {
  const TemporaryFolder folder;
  ProgramMemory memory(folder.path(), 100);
  int changes = 0;
  memory.on_change([&] { ++changes; });
  const std::string empty = memory.census_hash();
  memory.put("A", "1");
  const std::string one = memory.census_hash();
  memory.put("A", "2");
  EXPECT_NE(one, empty);
  EXPECT_NE(memory.census_hash(), one);
  memory.remove("A");
  EXPECT_EQ(memory.census_hash(), empty);
  EXPECT_EQ(memory.remove("A").reason, "not_found");
  EXPECT_EQ(changes, 3);
}

TEST(ProgramMemory, UnusableFolderIsAClearError) {
  EXPECT_THROW(ProgramMemory("/proc/no-programs-here", 100), std::runtime_error);
}

}  // namespace
}  // namespace headstock::link
