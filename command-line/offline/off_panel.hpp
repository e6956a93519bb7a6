// The reviewed part of the coverage report: dialects/<folder>/off-panel.tsv. Columns: kind (gcodes, mcodes,
// alarms, parameters, variables), series (T, M or empty), codes, state (`done`: another part of Headstock
// does it; `assumed`: done, but the manual's text does not say what it does; `off-panel`: it has no meaning here), reason.
// The first row that matches counts: particular rows come first.
#pragma once

#include <string_view>
#include <vector>

namespace headstock::offline {

struct OffPanel {
  std::string_view kind;
  std::string_view codes;  ///< patterns, separated by commas: "M29", "6581..6595" (bits included), "SV*"
  bool done = false;
  bool assumed = false;  ///< done, and the reason says what it is made from instead of where
  std::string_view reason;
};

/// Rows of the profile, in the order of the file. Empty for an unknown profile.
std::vector<OffPanel> off_panel_rows(std::string_view profile);

/// The row that speaks about the code, or nullptr.
const OffPanel* off_panel(std::string_view profile, std::string_view kind, std::string_view code);

bool matches(std::string_view pattern, std::string_view code);

template <typename Use>
void for_each_pattern(std::string_view codes, Use use) {
  while (!codes.empty()) {
    const std::size_t comma = std::min(codes.find(", "), codes.size());
    use(codes.substr(0, comma));
    codes.remove_prefix(std::min(codes.size(), comma + 2));
  }
}

}  // namespace headstock::offline
