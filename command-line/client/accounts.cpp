// headstock login, logout, users.

#include <fstream>
#include <iostream>
#include <memory>

#include <termios.h>
#include <unistd.h>

#include "command-line/client/client.hpp"
#include "command-line/client/output.hpp"
#include "protocol/process/options.hpp"

namespace headstock::client {

namespace {

std::string without_line_end(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text;
}

/// From a file, from stdin ("-"), or asked for without showing it.
std::string read_password(const std::string& file, const std::string& prompt) {
  std::string line;
  if (!file.empty() && file != "-") {
    std::ifstream in(file);
    if (!in) throw Failure(usage, say("cannot read ", "无法读取 ") + file);
    // Also the server's own first-sign-in file: "password: …".
    for (std::string row; std::getline(in, row);) {
      if (row.starts_with("user: ")) continue;
      line = row.starts_with("password: ") ? row.substr(10) : row;
      break;
    }
    return without_line_end(line);
  }
  if (file == "-" || ::isatty(STDIN_FILENO) == 0) {
    std::getline(std::cin, line);
    return without_line_end(line);
  }
  std::cerr << prompt << std::flush;
  termios before{};
  ::tcgetattr(STDIN_FILENO, &before);
  termios silent = before;
  silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
  ::tcsetattr(STDIN_FILENO, TCSANOW, &silent);
  std::getline(std::cin, line);
  ::tcsetattr(STDIN_FILENO, TCSANOW, &before);
  std::cerr << "\n";
  return without_line_end(line);
}

struct Login {
  std::string server, user, password_file, ca;
};

void login(const Context& context, const Login& given) {
  Server server;
  server.url = given.server;
  while (server.url.ends_with('/')) server.url.pop_back();
  if (!given.ca.empty()) server.ca = std::filesystem::absolute(given.ca);
  const auto password = read_password(given.password_file, say("Password: ", "密码："));
  Connection connection(server);
  auto answer = connection.send("POST", "/session", {{"user", given.user}, {"password", password}});
  server.token = answer.at("token").get<std::string>();
  context.save(server);
  answer.erase("token");   // not into logs and scroll-back
  std::string text = say("signed in as ", "已登录：") + given.user + " (" + answer.value("role", std::string()) + ")";
  if (answer.value("must_change_password", false))
    text += say("\nchange the password soon: headstock password", "\n请尽快修改密码：headstock password");
  show(context, answer, text);
}

struct UserFields {
  std::string user, name, role, language, password_file;
  bool disable = false, enable = false;
};

json find_user(Connection& server, const std::string& wanted) {
  const auto list = server.get("/users");
  for (const auto& user : list.at("items"))
    if (user.value("user", std::string()) == wanted) return user;
  throw Failure(refused, say("there is no user ", "没有用户 ") + wanted);
}

std::string user_table(const json& list) {
  std::vector<Line> rows;
  for (const auto& user : list)
    rows.push_back({cell(user.at("user")), cell(user.at("name")), cell(user.at("role")), cell(user.at("language")),
                    cell(user.at("disabled")), local_time(user.at("last_sign_in"))});
  return table({say("user", "用户"), say("name", "姓名"), say("role", "角色"), say("language", "语言"),
                say("disabled", "停用"), say("last sign-in", "上次登录")},
               rows);
}

void add_users(options::Command app, Context& context) {
  auto users = app.add_command("users", "Users and their roles (administrator)");
  users.requires_command();
  users.add_command("list", "All users").callback([&context] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto list = server.get("/users").at("items");
      show(context, list, user_table(list));
    });
  });
  const auto fields = std::make_shared<UserFields>();
  const std::vector<std::string> roles = {"viewer", "operator", "programmer", "setter", "administrator"};
  auto add = users.add_command("add", "Create a user");
  add.option("USER", fields->user).required();
  add.option("--role", fields->role).required().one_of(roles);
  add.option("--name", fields->name);
  add.option("--language", fields->language).one_of({"en", "zh"});
  add.option("--password-file", fields->password_file, "File with the first password, - for stdin");
  add.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      json body = {{"user", fields->user}, {"role", fields->role}};
      if (!fields->name.empty()) body["name"] = fields->name;
      if (!fields->language.empty()) body["language"] = fields->language;
      body["password"] = read_password(fields->password_file, say("First password: ", "初始密码："));
      const auto user = server.send("POST", "/users", body);
      show(context, user, user_table(json::array({user})));
    });
  });
  auto set = users.add_command("set", "Change a user");
  set.option("USER", fields->user).required();
  set.option("--role", fields->role).one_of(roles);
  set.option("--name", fields->name);
  set.option("--language", fields->language).one_of({"en", "zh"});
  set.option("--password-file", fields->password_file, "File with a new password, - for stdin");
  set.flag("--disable", fields->disable);
  set.flag("--enable", fields->enable).excludes("--disable");
  set.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      json body = json::object();
      if (!fields->role.empty()) body["role"] = fields->role;
      if (!fields->name.empty()) body["name"] = fields->name;
      if (!fields->language.empty()) body["language"] = fields->language;
      if (fields->disable || fields->enable) body["disabled"] = fields->disable;
      if (!fields->password_file.empty()) body["password"] = read_password(fields->password_file, "");
      const auto user = server.send("PATCH", "/users/" + find_user(server, fields->user).at("id").dump(), body);
      show(context, user, user_table(json::array({user})));
    });
  });
  auto remove = users.add_command("remove", "Remove a user; what they did stays in the records");
  remove.option("USER", fields->user).required();
  remove.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      server.send("DELETE", "/users/" + find_user(server, fields->user).at("id").dump(), nullptr);
      show(context, {{"removed", fields->user}}, say("removed ", "已删除 ") + fields->user);
    });
  });
}

}  // namespace

void add_account_commands(options::Command app, Context& context) {
  const auto given = std::make_shared<Login>();
  auto in = app.add_command("login", "Sign in to a server; the token is kept in a file only you can read");
  in.option("--server", given->server, "http://127.0.0.1:8080 or https://…").required();
  in.option("--user", given->user).required();
  in.option("--password-file", given->password_file, "File with the password, - for stdin; asked for unless given");
  in.option("--ca", given->ca, "CA certificate (PEM) to trust, for servers that made their own");
  in.callback([&context, given] { guarded(context, [&] { login(context, *given); }); });

  app.add_command("logout", "Sign out and forget the token").callback([&context] {
    guarded(context, [&] {
      auto server = context.connect();
      context.forget();   // also when the server cannot be told
      server.send("DELETE", "/session", nullptr);
      show(context, {{"signed_out", true}}, say("signed out", "已退出登录"));
    });
  });

  struct Passwords {
    std::string old_file, new_file;
  };
  const auto passwords = std::make_shared<Passwords>();
  auto password = app.add_command("password", "Change the own password");
  password.option("--old-file", passwords->old_file, "File with the old password");
  password.option("--new-file", passwords->new_file, "File with the new password");
  password.callback([&context, passwords] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto old_one = read_password(passwords->old_file, say("Old password: ", "旧密码："));
      const auto new_one = read_password(passwords->new_file, say("New password: ", "新密码："));
      server.send("POST", "/session/password", {{"old", old_one}, {"new", new_one}});
      show(context, {{"changed", true}}, say("password changed", "密码已修改"));
    });
  });
  add_users(app, context);
}

}  // namespace headstock::client
