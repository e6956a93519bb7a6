// `headstock profile P`: prints what a controller's catalogue holds, for people and for scripts.
#pragma once

namespace CLI {
class App;
}

namespace headstock::offline {

/// Adds the sub-command `profile`. @param status set to the exit status when it runs: 0, or 1 for an unknown profile.
void add_profile(CLI::App& app, int& status);

}  // namespace headstock::offline
