// The coverage report as the page that every dialect's folder holds.
#include <algorithm>
#include <sstream>

#include "command-line/offline/coverage.hpp"

namespace headstock::offline {
namespace {

constexpr std::pair<std::string_view, std::string_view> kTitles[] = {{"gcodes", "G codes"},
                                                                     {"mcodes", "M codes"},
                                                                     {"alarms", "Alarms"},
                                                                     {"parameters", "Parameters"},
                                                                     {"variables", "System variables"}};

// A table's cell must not hold what Markdown reads as the end of it.
std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

// Codes by what is said about them, in the order of their first.
void by_reason(std::ostream& out, const CoverageOf& part, State state) {
  std::vector<std::pair<std::string_view, std::string>> groups;
  for (const Covered& item : part.items) {
    if (item.state != state) continue;
    auto group = std::find_if(groups.begin(), groups.end(),
                              [&item](const auto& one) { return one.first == item.reason; });
    if (group == groups.end()) group = groups.insert(groups.end(), {item.reason, ""});
    if (!group->second.empty()) group->second += ", ";
    group->second += item.code;
  }
  for (const auto& [reason, codes] : groups)
    out << "| " << cell(codes) << " | " << cell(reason.empty() ? std::string_view("to the machine") : reason)
        << " |\n";
}

void section(std::ostream& out, const CoverageOf& part, std::string_view title) {
  out << "\n## " << title << "\n";
  if (part.count(State::missing) != 0) {
    out << "\n**Missing**\n\n| code | what |\n|---|---|\n";
    for (const Covered& item : part.items)
      if (item.state == State::missing) out << "| " << cell(item.code) << " | " << cell(item.name) << " |\n";
  }
  if (part.count(State::off_panel) != 0) {
    out << "\n**No meaning off the control's panel**\n\n| codes | why |\n|---|---|\n";
    by_reason(out, part, State::off_panel);
  }
  if (part.count(State::done) != 0) {
    out << "\n**Done**\n\n| codes | where |\n|---|---|\n";
    by_reason(out, part, State::done);
  }
}

}  // namespace

std::string coverage_page(std::string_view profile) {
  const auto parts = coverage(profile);
  std::ostringstream out;
  out << "# " << profile << ": what is done\n\nWritten by `headstock profile " << profile
      << " --coverage --page` (build target `coverage_pages`); do not edit.\n\n"
         "| | in the manual | done | off the panel | missing |\n|---|---|---|---|---|\n";
  const auto title = [](std::string_view kind) {
    return std::find_if(std::begin(kTitles), std::end(kTitles),
                        [kind](const auto& one) { return one.first == kind; })
        ->second;
  };
  for (const CoverageOf& part : parts)
    out << "| " << title(part.kind) << " | " << part.items.size() << " | " << part.count(State::done) << " | "
        << part.count(State::off_panel) << " | " << part.count(State::missing) << " |\n";
  for (const CoverageOf& part : parts) section(out, part, title(part.kind));
  return out.str();
}

}  // namespace headstock::offline
