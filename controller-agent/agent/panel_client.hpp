// `headstock-agent panel …`: the buttons of the machine's panel, typed at the machine.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace headstock::agent {

/// The verbs and what they do, for --help.
std::string panel_help();

/// Carries out one panel command and prints the answer.
/// @return 0 accepted, 2 refused by the machine, 1 wrong usage or no agent running there.
int run_panel(const std::filesystem::path& folder, const std::vector<std::string>& words);

}  // namespace headstock::agent
