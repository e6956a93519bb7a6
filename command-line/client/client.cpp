#include "command-line/client/client.hpp"

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <thread>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "command-line/client/output.hpp"
#include "protocol/process/options.hpp"

namespace headstock::client {

namespace fs = std::filesystem;

fs::path default_session_file() {
  if (const char* file = std::getenv("HEADSTOCK_SESSION"); file && *file) return file;
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config && *config) return fs::path(config) / "headstock" / "session";
  const char* home = std::getenv("HOME");
  return fs::path(home && *home ? home : ".") / ".config" / "headstock" / "session";
}

fs::path Context::file() const { return session_file.empty() ? default_session_file() : session_file; }

Server Context::load() const {
  std::ifstream in(file());
  const auto kept = json::parse(in, nullptr, false);
  if (!kept.is_object() || !kept.contains("server") || !kept.contains("token"))
    throw Failure(not_signed_in, say("not signed in; use: headstock login --server URL --user NAME",
                                     "尚未登录；请使用 headstock login --server URL --user NAME"));
  Server server;
  server.url = kept.value("server", std::string());
  server.token = kept.value("token", std::string());
  server.ca = kept.value("ca", std::string());
  return server;
}

void Context::save(const Server& server) const {
  const auto path = file();
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  const auto text = json{{"server", server.url}, {"token", server.token}, {"ca", server.ca.string()}}.dump() + "\n";
  const fs::path temporary = path.string() + ".new";
  const int out = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  const bool written = out >= 0 && ::fchmod(out, 0600) == 0 &&
                       ::write(out, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (out >= 0) ::close(out);
  if (written) fs::rename(temporary, path, error);
  if (!written || error) throw Failure(usage, say("cannot write ", "无法写入 ") + path.string());
}

void Context::forget() const {
  std::error_code ignored;
  fs::remove(file(), ignored);
}

Connection Context::connect() const { return Connection(load()); }

void guarded(Context& context, const std::function<void()>& body) {
  choose_language(context.language);
  try {
    body();
  } catch (const Failure& failure) {
    context.status = failure.status();
    if (context.as_json)
      std::cout << (failure.answer().is_object() ? failure.answer() : json{{"error", {{"code", "client"}, {"text", failure.what()}}}}).dump() << "\n";
    std::cerr << "headstock: " << failure.what() << "\n";
  } catch (const std::exception& error) {
    context.status = usage;
    std::cerr << "headstock: " << error.what() << "\n";
  }
}

void show(const Context& context, const json& value, const std::string& text) {
  if (context.as_json)
    std::cout << value.dump() << "\n";
  else
    std::cout << text << (text.empty() || text.back() == '\n' ? "" : "\n");
  std::cout.flush();
}

json find_machine(Connection& server, const std::string& wanted) {
  const auto list = server.get("/machines");
  for (const auto& machine : list.at("items"))
    if (machine.value("name", std::string()) == wanted) return machine;
  for (const auto& machine : list.at("items"))
    if (std::to_string(machine.value("id", 0)) == wanted) return machine;
  throw Failure(refused, say("there is no machine ", "没有机床 ") + wanted);
}

json find_program(Connection& server, const std::string& wanted) {
  if (!wanted.empty() && wanted.find_first_not_of("0123456789") == std::string::npos) return server.get("/programs/" + wanted);
  const auto slash = wanted.rfind('/');
  const auto name = slash == std::string::npos ? wanted : wanted.substr(slash + 1);
  std::string folder = slash == std::string::npos ? "" : wanted.substr(0, slash);
  if (slash != std::string::npos && !folder.starts_with('/')) folder = "/" + folder;
  std::vector<json> found;
  std::string cursor;
  do {
    const auto page = server.get("/programs?limit=1000&q=" + encoded(name) +
                                 (slash == std::string::npos ? "" : "&folder=" + encoded(folder)) +
                                 (cursor.empty() ? "" : "&cursor=" + cursor));
    for (const auto& program : page.at("items"))
      if (program.value("name", std::string()) == name) found.push_back(program);
    cursor = page.at("next").is_string() ? page.at("next").get<std::string>() : "";
  } while (!cursor.empty());
  if (found.empty()) throw Failure(refused, say("there is no program ", "没有程序 ") + wanted);
  if (found.size() > 1)
    throw Failure(refused, wanted + say(" is in several folders; say which: /FOLDER/NAME", " 存在于多个文件夹，请写明 /文件夹/名称"));
  return found.front();
}

json finished(Connection& server, json answer) {
  while (answer.is_object() && answer.contains("job") && answer.value("state", "") == "running") {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    answer = server.get("/jobs/" + answer.at("job").dump());
  }
  if (!answer.is_object() || !answer.contains("job")) return answer;
  if (answer.value("state", "") == "failed") {
    const auto& error = answer.at("error");
    throw Failure(refused, error.is_object() ? text_of(error.value("message", json())) : say("failed", "失败"), answer);
  }
  return answer.at("result");
}

void add_client(options::Command app, Context& context) {
  app.flag("--json", context.as_json, "Print JSON (one object or array) instead of text");
  app.option("--lang", context.language, "en or zh; from the environment unless given").one_of({"en", "zh"});
  app.option("--session", context.session_file, "File that keeps the sign-in (default: ~/.config/headstock/session)");
  app.shares_options();
  add_account_commands(app, context);
  add_machine_commands(app, context);
  add_program_commands(app, context);
  add_operate_commands(app, context);
  add_value_commands(app, context);
  add_port_commands(app, context);
  add_keeping_commands(app, context);
}

}  // namespace headstock::client
