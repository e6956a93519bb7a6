// `headstock check`: dry-runs programs and prints what the controller would object to.
#include <iostream>

#include "dialects/catalogue.hpp"
#include "offline/offline.hpp"
#include "offline/session.hpp"
#include "protocol/process/options.hpp"

namespace headstock::offline {
namespace {

// @return 0, 1 (cannot be read) or 2 (alarm).
int check(const Options& options, const std::string& file) {
  std::string error;
  const auto session = make_session(options, error);
  auto source = session ? open_program(file) : nullptr;
  if (session && source == nullptr) error = file + ": cannot be read";
  if (!error.empty()) {
    std::cerr << "headstock check: " << error << "\n";
    return 1;
  }
  if (file != "-") session->programs.add_file(file);
  interp::Interpreter interpreter(*session->dialect, session->machine, session->data, &session->programs);
  interpreter.set_switches(session->switches);
  interpreter.start(std::move(source), session->start_position());
  interp::Operation operation;
  int status = 0;
  while (interpreter.next(operation) == interp::Pull::operation) {
    const auto* alarm = std::get_if<interp::Alarm>(&operation);
    if (alarm == nullptr) continue;
    std::cout << file << ':' << alarm->at.line << ':' << alarm->at.column << ": " << alarm->code << ' '
              << dialects::alarm_text(session->dialect->profile, alarm->code).en
              << (alarm->detail.empty() ? "" : " [" + alarm->detail + "]") << '\n';
    status = 2;
  }
  return status;
}

}  // namespace

void add_check(options::Command app, int& exit_status) {
  struct State {
    Options options;
    std::vector<std::string> files;
  };
  const auto state = std::make_shared<State>();
  auto command = app.add_command("check", "Dry-run programs: FILE:LINE:COLUMN: CODE text for each alarm");
  add_options(command, state->options);
  command.option("files", state->files, "Programs").required();
  command.callback([state, &exit_status] {
    for (const std::string& file : state->files) {
      const int status = check(state->options, file);
      exit_status = exit_status == 1 || status == 1 ? 1 : std::max(exit_status, status);
    }
  });
}

}  // namespace headstock::offline
