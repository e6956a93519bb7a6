// headstock machines, alarms, parts.

#include <fstream>
#include <iterator>
#include <memory>

#include "command-line/client/client.hpp"
#include "command-line/client/output.hpp"
#include "protocol/process/options.hpp"

namespace headstock::client {

namespace {

std::string alarms_of(const json& live) {
  std::string text;
  const auto alarms = live.value("alarms", json::array());
  if (alarms.is_array())
    for (const auto& alarm : alarms) text += (text.empty() ? "" : "; ") + alarm.value("code", std::string()) + " " + text_of(alarm.value("text", json()));
  return text;
}

std::string machine_table(const json& machines) {
  std::vector<Line> rows;
  for (const auto& machine : machines) {
    const json live = machine.at("live").is_object() ? machine.at("live") : json::object();
    const json program = live.value("program", json());
    const json parts = live.value("parts", json());
    rows.push_back({cell(machine.at("id")), cell(machine.at("name")), cell(machine.at("profile")),
                    state_word(live.value("state", std::string("unknown"))),
                    program.is_object() ? cell(program.value("name", json())) : "–",
                    parts.is_object() ? cell(parts.value("count", json())) : "–", alarms_of(live)});
  }
  return table({say("id", "编号"), say("name", "名称"), say("controller", "数控系统"), say("state", "状态"),
                say("program", "程序"), say("parts", "件数"), say("alarms", "报警")},
               rows);
}

std::string read_text(const std::string& file) {
  if (file.empty()) return "";
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Failure(usage, say("cannot read ", "无法读取 ") + file);
  return {std::istreambuf_iterator<char>(in), {}};
}

void add_machines(options::Command app, Context& context) {
  struct Fields {
    std::string machine, name, profile, toml;
    bool yes = false;
  };
  const auto fields = std::make_shared<Fields>();
  const auto list = [&context] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto machines = server.get("/machines").at("items");
      show(context, machines, machine_table(machines));
    });
  };
  auto machines = app.add_command("machines", "Machines: list, add, token, show, resident, remove");
  machines.allows_command();
  machines.callback([machines, list] {
    if (machines.alone()) list();
  });
  machines.add_command("list", "All machines and what they do").callback(list);
  auto add = machines.add_command("add", "Create a machine and a token with which its agent enrols once");
  add.option("NAME", fields->name).required();
  add.option("--profile", fields->profile, "fanuc-0i-t, fanuc-0i-m, gsk-2000tc, gsk-218t, k2000tc, lathe-200t").required();
  add.option("--machine", fields->toml, "Machine file (TOML): axes, limits, spindle");
  add.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto made = server.send("POST", "/machines",
                                    {{"name", fields->name}, {"profile", fields->profile}, {"toml", read_text(fields->toml)}});
      show(context, made, say("machine ", "机床 ") + made.at("id").dump() + "\n" + say("token (once, valid one hour): ", "令牌（一次性，一小时内有效）：") +
                              made.at("enrolment_token").get<std::string>());
    });
  });
  auto token = machines.add_command("token", "A new one-time token for a machine's agent");
  token.option("MACHINE", fields->machine).required();
  token.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto id = find_machine(server, fields->machine).at("id").dump();
      const auto made = server.send("POST", "/machines/" + id + "/enrolment");
      show(context, made, made.at("enrolment_token").get<std::string>());
    });
  });
  auto one = machines.add_command("show", "One machine as JSON");
  one.option("MACHINE", fields->machine).required();
  one.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto machine = server.get("/machines/" + find_machine(server, fields->machine).at("id").dump());
      show(context, machine, machine.dump(2));
    });
  });
  auto resident = machines.add_command("resident", "Programs in a machine's memory");
  resident.option("MACHINE", fields->machine).required();
  resident.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto programs = server.get("/machines/" + find_machine(server, fields->machine).at("id").dump() + "/programs").at("items");
      std::vector<Line> rows;
      for (const auto& program : programs)
        rows.push_back({cell(program.at("name")), cell(program.at("bytes")), cell(program.at("revision")),
                        cell(program.at("stale")), cell(program.at("selected")), local_time(program.at("since"))});
      show(context, programs, table({say("name", "名称"), say("bytes", "字节"), say("revision", "版本"), say("stale", "过期"),
                                     say("selected", "已选择"), say("since", "自")}, rows));
    });
  });
  auto remove = machines.add_command("remove", "Remove a machine; its history stays");
  remove.option("MACHINE", fields->machine).required();
  remove.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      server.send("DELETE", "/machines/" + find_machine(server, fields->machine).at("id").dump(), nullptr);
      show(context, {{"removed", fields->machine}}, say("removed ", "已删除 ") + fields->machine);
    });
  });
}

struct History {
  std::string machine, from, to, code, text;
  bool active = false;
  int limit = 100;
};

void add_history_options(options::Command command, History& history) {
  command.option("--machine", history.machine, "Only this machine (id or name)");
  command.option("--from", history.from, "Time or date, inclusive (UTC)");
  command.option("--to", history.to, "Time or date, exclusive (UTC)");
  command.option("--limit", history.limit, "At most so many, newest first").shows_default().between(1, 1000);
}

std::string query_of(Connection& server, const History& history) {
  std::string query = "?limit=" + std::to_string(history.limit);
  if (!history.machine.empty()) query += "&machine=" + find_machine(server, history.machine).at("id").dump();
  if (!history.from.empty()) query += "&from=" + encoded(history.from);
  if (!history.to.empty()) query += "&to=" + encoded(history.to);
  if (!history.code.empty()) query += "&code=" + encoded(history.code);
  if (!history.text.empty()) query += "&q=" + encoded(history.text);
  if (history.active) query += "&active=true";
  return query;
}

}  // namespace

void add_machine_commands(options::Command app, Context& context) {
  add_machines(app, context);
  const auto history = std::make_shared<History>();
  auto alarms = app.add_command("alarms", "Alarm history, newest first");
  add_history_options(alarms, *history);
  alarms.option("--code", history->code, "Exactly this code");
  alarms.option("--text", history->text, "Part of code, text, program or block");
  alarms.flag("--active", history->active, "Only alarms not cleared");
  alarms.callback([&context, history] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto list = server.get("/alarms" + query_of(server, *history)).at("items");
      std::vector<Line> rows;
      for (const auto& alarm : list)
        rows.push_back({local_time(alarm.at("raised")), cell(alarm.at("machine")), cell(alarm.at("code")), text_of(alarm.at("text")),
                        cell(alarm.at("program")), cell(alarm.at("line")), local_time(alarm.at("cleared"))});
      show(context, list, table({say("raised", "发生"), say("machine", "机床"), say("code", "代码"), say("text", "内容"),
                                 say("program", "程序"), say("line", "行"), say("cleared", "解除")}, rows));
    });
  });
  auto parts = app.add_command("parts", "Parts counted, newest first");
  add_history_options(parts, *history);
  parts.callback([&context, history] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto answer = server.get("/parts" + query_of(server, *history));
      std::vector<Line> rows;
      for (const auto& part : answer.at("items"))
        rows.push_back({local_time(part.at("at")), cell(part.at("machine")), cell(part.at("program")), cell(part.at("count")),
                        cell(part.at("total")), duration(part.at("cycle_s"))});
      show(context, answer, table({say("time", "时间"), say("machine", "机床"), say("program", "程序"), say("count", "件数"),
                                   say("total", "总数"), say("cycle", "循环时间")}, rows) +
                                say("total in this time: ", "该时段合计：") + answer.at("total").dump());
    });
  });
}

}  // namespace headstock::client
