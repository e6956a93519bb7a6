// `headstock`: the client of the server, and the tools that need no server.

#include "client/client.hpp"
#include "offline/offline.hpp"
#include "offline/simulate.hpp"
#include "protocol/process/options.hpp"

int main(int argc, char** argv) {
  headstock::options::Program app("Headstock: machine-shop programs, machines and controllers", "headstock");
  app.version(std::string("headstock ") + HEADSTOCK_VERSION);
  app.requires_command();
  headstock::client::Context context;
  headstock::offline::add_interpret(app, context.status);
  headstock::offline::add_check(app, context.status);
  headstock::offline::add_plot(app, context.status);
  headstock::offline::add_profile(app, context.status);
  headstock::offline::add_simulate(app, context.status);
  headstock::offline::add_convert_tape(app, context.status);
  headstock::offline::add_dnc(app, context.status);
  headstock::client::add_client(app, context);
  app.footer("Exit status of the client's commands: 0 done, 1 usage or a local file, 2 refused by server or machine,\n"
             "3 server not reachable, 4 not signed in. The offline tools: 0 done, 1 usage or a file, 2 an alarm.");
  if (const auto ended = app.parse(argc, argv, 1)) return *ended;
  return context.status;
}
