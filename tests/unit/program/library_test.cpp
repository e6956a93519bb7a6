#include "program/library.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace headstock::program {
namespace {

std::string read_all(Source* source) {
  if (source == nullptr) return "(none)";
  std::string text;
  char buffer[7];
  for (;;) {
    const ReadResult got = source->read(buffer);
    if (got.status != ReadStatus::data) return text;
    text.append(buffer, got.bytes);
  }
}

TEST(FilePrograms, OneTextWithSeveralPrograms) {
  FilePrograms programs;
  programs.add_text("%\nO0001\nM98 P10\nM30\nO10 (SUB)\nG0 X1\nM99\n:20\nM99\n%");
  EXPECT_EQ(read_all(programs.open_number(1).get()), "O0001\nM98 P10\nM30\n");
  const auto sub = programs.open_number(10);
  EXPECT_EQ(read_all(sub.get()), "O10 (SUB)\nG0 X1\nM99\n");
  ASSERT_TRUE(sub->seek(0));
  EXPECT_EQ(read_all(sub.get()), "O10 (SUB)\nG0 X1\nM99\n");
  EXPECT_FALSE(sub->seek(1'000));
  EXPECT_EQ(read_all(programs.open_number(20).get()), ":20\nM99\n%");
  EXPECT_EQ(programs.open_number(30), nullptr);
}

TEST(FilePrograms, FolderByNumberAndName) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("headstock_programs_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "O0100.nc") << "hundred";
  std::ofstream(folder / "o200") << "two hundred";
  std::ofstream(folder / "NT11") << "named";
  FilePrograms programs;
  programs.add_folder(folder);
  EXPECT_EQ(read_all(programs.open_number(100).get()), "hundred");
  EXPECT_EQ(read_all(programs.open_number(200).get()), "two hundred");
  EXPECT_EQ(read_all(programs.open_name("nt11").get()), "named");
  EXPECT_EQ(programs.open_number(300), nullptr);
  EXPECT_EQ(programs.open_name("../NT11"), nullptr);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace headstock::program
