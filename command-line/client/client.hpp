// The sub-commands of `headstock` that talk to a server. One group a file.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "command-line/client/connection.hpp"

namespace headstock::options {
class Command;
}

namespace headstock::client {

/// What all commands share. Filled by the options of the application before a command runs.
struct Context {
  bool as_json = false;
  std::string language;                 ///< "en", "zh" or empty: from the environment
  std::filesystem::path session_file;   ///< empty: default_session_file()
  int status = Status::ok;

  /// The server last signed in to. Throws Failure{not_signed_in}.
  Connection connect() const;
  Server load() const;
  void save(const Server& server) const;
  void forget() const;
  std::filesystem::path file() const;
};

/// $HEADSTOCK_SESSION, otherwise $XDG_CONFIG_HOME/headstock/session, otherwise ~/.config/headstock/session.
std::filesystem::path default_session_file();

/// Runs a command's body; what it throws becomes a line on stderr (with --json an object on stdout) and a status.
void guarded(Context& context, const std::function<void()>& body);
/// With --json the value, otherwise the text.
void show(const Context& context, const json& value, const std::string& text);

void add_account_commands(options::Command app, Context& context);   // login, logout, users
void add_machine_commands(options::Command app, Context& context);   // machines, alarms, parts
void add_program_commands(options::Command app, Context& context);   // programs …
void add_operate_commands(options::Command app, Context& context);   // run, hold, reset, drip, watch
void add_port_commands(options::Command app, Context& context);      // ports, received
void add_value_commands(options::Command app, Context& context);     // offsets, tool-life, parameters, variables, recount
void add_port_record_commands(options::Command ports, Context& context);   // of `ports`: census, plans, log, tail, data
void add_keeping_commands(options::Command app, Context& context);   // audit, backup

/// Adds --json, --lang, --session and all groups.
void add_client(options::Command app, Context& context);

/// The machine with this id or name. Throws Failure{refused}.
json find_machine(Connection& server, const std::string& wanted);
/// The program with this id, path ("/shafts/O1001") or, if only one has it, name.
json find_program(Connection& server, const std::string& wanted);
/// Asks until a check or back-plot that was answered with 202 is done.
json finished(Connection& server, json answer);

}  // namespace headstock::client
