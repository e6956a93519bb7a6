// `headstock`: the command line.
#include <CLI/CLI.hpp>

#include "offline/offline.hpp"
#include "offline/simulate.hpp"

int main(int argc, char** argv) {
  CLI::App app{"Headstock: machine-shop programs, machines and controllers", "headstock"};
  app.require_subcommand(1);
  int exit_status = 0;
  headstock::offline::add_interpret(app, exit_status);
  headstock::offline::add_check(app, exit_status);
  headstock::offline::add_profile(app, exit_status);
  headstock::offline::add_simulate(app, exit_status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  }
  return exit_status;
}
