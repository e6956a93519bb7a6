#include "case_file.hpp"

#include <fstream>
#include <sstream>

namespace headstock::conformance {
namespace {

Expected read_expected(const std::string& line) {
  Expected expected;
  std::istringstream words(line);
  words >> expected.op;
  std::string word;
  while (words >> word) {
    if (word[0] == '#') break;
    const auto equals = word.find('=');
    if (equals != word.npos) {
      expected.values[word.substr(0, equals)] = word.substr(equals + 1);
    } else {
      expected.word = word;
    }
  }
  return expected;
}

}  // namespace

Case read_case(const std::filesystem::path& file, std::string& mistake) {
  Case read;
  read.file = file;
  std::ifstream in(file);
  enum class Part { settings, program, others, named, expected } part = Part::settings;
  std::string name;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.rfind("--- ", 0) == 0) {
      const std::string title = line.substr(4);
      if (title == "program") {
        part = Part::program;
      } else if (title == "subprograms") {
        part = Part::others;
      } else if (title.rfind("subprogram ", 0) == 0) {
        part = Part::named;
        name = title.substr(11);
      } else if (title == "expect") {
        part = Part::expected;
      } else {
        mistake = "line " + std::to_string(number) + ": unknown part " + title;
      }
      continue;
    }
    switch (part) {
      case Part::settings: {
        if (line.empty() || line[0] == '#') break;
        const auto colon = line.find(": ");
        if (colon == line.npos) {
          mistake = "line " + std::to_string(number) + ": not `key: value`";
          break;
        }
        read.settings[line.substr(0, colon)] = line.substr(colon + 2);
        break;
      }
      case Part::program:
        read.program += line + "\n";
        break;
      case Part::others:
        read.others += line + "\n";
        break;
      case Part::named:
        read.named[name] += line + "\n";
        break;
      case Part::expected:
        if (line.empty() || line[0] == '#') break;
        read.expected.push_back(read_expected(line));
        read.expected.back().file_line = number;
        break;
    }
  }
  if (read.settings.count("profile") == 0) mistake = "no `profile:`";
  if (read.settings.count("source") == 0) mistake = "no `source:`";
  if (read.expected.empty()) mistake = "nothing is expected";
  return read;
}

}  // namespace headstock::conformance
