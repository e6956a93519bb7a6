// `headstock interpret`: a program's canonical operations as JSON Lines on stdout.
#include <cstdio>
#include <iostream>

#include "offline/json_lines.hpp"
#include "offline/offline.hpp"
#include "offline/session.hpp"
#include "protocol/process/options.hpp"

namespace headstock::offline {
namespace {

constexpr std::size_t kWriteBytes = 64 * 1024;

int interpret(const Options& options, const std::string& file) {
  std::string error;
  const auto session = make_session(options, error);
  auto source = session ? open_program(file) : nullptr;
  if (session && source == nullptr) error = file + ": cannot be read";
  if (!error.empty()) {
    std::cerr << "headstock interpret: " << error << "\n";
    return 1;
  }
  if (file != "-") session->programs.add_file(file);
  interp::Interpreter interpreter(*session->dialect, session->machine, session->data, &session->programs);
  interpreter.set_switches(session->switches);
  interpreter.start(std::move(source), session->start_position());

  const JsonLines records(session->machine, session->dialect->profile);
  interp::Operation operation;
  std::string out;
  out.reserve(2 * kWriteBytes);
  int status = 0;
  while (interpreter.next(operation) == interp::Pull::operation) {
    records.append(operation, out);
    if (std::holds_alternative<interp::Alarm>(operation)) status = 2;
    if (out.size() < kWriteBytes) continue;
    if (std::fwrite(out.data(), 1, out.size(), stdout) != out.size()) return 1;
    out.clear();
  }
  if (std::fwrite(out.data(), 1, out.size(), stdout) != out.size() || std::fflush(stdout) != 0) return 1;
  return status;
}

}  // namespace

void add_interpret(options::Command app, int& exit_status) {
  struct State {
    Options options;
    std::string file;
  };
  const auto state = std::make_shared<State>();
  auto command =
      app.add_command("interpret", "Show what a program means: canonical operations as JSON Lines");
  add_options(command, state->options);
  command.option("file", state->file, "Program, - for standard input").required();
  command.callback([state, &exit_status] { exit_status = interpret(state->options, state->file); });
}

}  // namespace headstock::offline
