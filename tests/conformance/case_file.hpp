// One conformance case: a readable file with a program, its settings and what the controller makes of it (see
// README).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace headstock::conformance {

struct Expected {
  int file_line = 0;                          ///< where it stands in the case file
  std::string op;                             ///< rapid, feed, arc, alarm …
  std::string word;                           ///< cw, ccw, stop, the alarm's code, the end's reason
  std::map<std::string, std::string> values;  ///< "X" → "200", "f" → "0.3", "line" → "4"
};

struct Case {
  std::filesystem::path file;
  std::map<std::string, std::string> settings;  ///< profile, set, start, axes, params, offsets, show …
  std::string program;                          ///< the main program
  std::string others;                           ///< sub-programs, each beginning with its O number
  std::map<std::string, std::string> named;     ///< sub-programs by name
  std::vector<Expected> expected;
};

/// @param mistake what is wrong with the file itself; empty when it was understood.
Case read_case(const std::filesystem::path& file, std::string& mistake);

}  // namespace headstock::conformance
