// headstock ports census | plans | unplan | log | certificate | tail | data: what ports leave behind and what is planned.

#include <fstream>
#include <iostream>
#include <memory>

#include "command-line/client/client.hpp"
#include "command-line/client/output.hpp"
#include "protocol/process/options.hpp"

namespace headstock::client {

namespace {

struct Asked {
  std::string machine, kind, from, to, output;
  std::int64_t id = 0;
};

template <class Run>
options::Command verb(options::Command app, Context& context, const std::shared_ptr<Asked>& asked, const char* name, const char* about, Run run) {
  auto made = app.add_command(name, about);
  made.callback([&context, asked, run] {
    guarded(context, [&] {
      auto server = context.connect();
      run(context, server, *asked);
    });
  });
  return made;
}

void census(Context& context, Connection& server, const Asked& asked) {
  std::string path = "/census";
  if (!asked.machine.empty()) path += "?machine=" + find_machine(server, asked.machine).at("id").dump();
  const auto items = server.get(path).at("items");
  std::vector<Line> rows;
  for (const auto& one : items)
    rows.push_back({cell(one.at("machine_name")), cell(one.at("port_name")), cell(one.at("name")), cell(one.at("state")),
                    cell(one.at("revision")), cell(one.at("released")), cell(one.at("proof")), local_time(one.at("proven")),
                    cell(one.at("sha256")).substr(0, 12)});
  show(context, items, table({say("machine", "机床"), say("port", "端口"), say("program", "程序"), say("state", "状态"),
                              say("revision", "版本"), say("released", "发布"), say("proof", "依据"), say("proven", "时间"), "sha256"}, rows));
}

void plans(Context& context, Connection& server, const Asked&) {
  const auto items = server.get("/port-plans").at("items");
  std::vector<Line> rows;
  for (const auto& one : items)
    rows.push_back({cell(one.at("id")), cell(one.at("port")), local_time(one.at("at")), cell(one.at("name")), cell(one.at("revision")),
                    cell(one.at("state")), cell(one.at("reason")), cell(one.at("transfer")), cell(one.at("by"))});
  show(context, items, table({say("id", "编号"), say("port", "端口"), say("time", "时间"), say("program", "程序"), say("revision", "版本"),
                              say("state", "状态"), say("reason", "原因"), say("transfer", "传输"), say("by", "操作者")}, rows));
}

void log(Context&, Connection& server, const Asked& asked) {
  std::string path = "/transfer-log";
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) path.append(path.find('?') == std::string::npos ? "?" : "&").append(name).append("=").append(encoded(value));
  };
  add("from", asked.from);
  add("to", asked.to);
  if (!asked.machine.empty()) add("machine", find_machine(server, asked.machine).at("id").dump());
  std::ofstream file;
  if (!asked.output.empty()) {
    file.open(asked.output, std::ios::binary | std::ios::trunc);
    if (!file) throw Failure(usage, say("cannot write ", "无法写入 ") + asked.output);
  }
  std::ostream& out = asked.output.empty() ? std::cout : file;
  server.download(path, [&](const char* bytes, std::size_t count) { out.write(bytes, static_cast<std::streamsize>(count)); });
  out.flush();
  if (!out) throw Failure(usage, say("cannot write ", "无法写入 ") + asked.output);
}

void tail(Context& context, Connection& server, const Asked& asked) {
  const auto found = server.get("/port-transfers/" + std::to_string(asked.id) + "/tail");
  if (found.at("text").is_null()) return show(context, found, say("nothing of a stored program was sent", "未发送任何存储的程序"));
  show(context, found, found.at("text").get<std::string>() + "\n" + say("last whole line: ", "最后完整行：") + cell(found.at("line")));
}

void data(Context& context, Connection& server, const Asked& asked) {
  if (asked.id != 0) {
    const auto one = server.get("/punched-data/" + std::to_string(asked.id));
    const auto& changes = one.at("changes");
    std::vector<Line> rows;
    if (one.at("against").is_null()) {
      for (const auto& value : one.at("values")) rows.push_back({cell(value.at("item")), cell(value.at("value"))});
      return show(context, one, table({say("item", "项目"), say("value", "数值")}, rows));
    }
    for (const auto& change : changes) rows.push_back({cell(change.at("item")), cell(change.at("before")), cell(change.at("after"))});
    return show(context, one, table({say("item", "项目"), say("before", "之前"), say("after", "之后")}, rows));
  }
  std::string path = "/punched-data?limit=200";
  if (!asked.machine.empty()) path += "&machine=" + find_machine(server, asked.machine).at("id").dump();
  if (!asked.kind.empty()) path += "&kind=" + encoded(asked.kind);
  const auto items = server.get(path).at("items");
  std::vector<Line> rows;
  for (const auto& one : items)
    rows.push_back({cell(one.at("id")), cell(one.at("machine")), cell(one.at("kind")), cell(one.at("entries")),
                    local_time(one.at("punched")), cell(one.at("by"))});
  show(context, items, table({say("id", "编号"), say("machine", "机床"), say("kind", "类型"), say("values", "数值"),
                              say("punched", "输出时间"), say("accepted by", "接受者")}, rows));
}

}  // namespace

void add_port_record_commands(options::Command ports, Context& context) {
  const auto asked = std::make_shared<Asked>();
  verb(ports, context, asked, "census", "What lies in every machine: revision, since when, proven by what", census)
      .option("--machine", asked->machine, "Only this machine");
  verb(ports, context, asked, "plans", "What is to be sent at a time, and what became of it", plans);
  verb(ports, context, asked, "unplan", "Take a plan back", [](Context& to, Connection& server, const Asked& given) {
    const auto plan = server.send("DELETE", "/port-plans/" + std::to_string(given.id));
    show(to, plan, cell(plan.at("name")) + " " + cell(plan.at("state")));
  }).option("ID", asked->id, "Number of the plan").required();
  auto table = verb(ports, context, asked, "log", "Every transfer, over ports and to agents, as comma-separated values", log);
  table.option("--from", asked->from, "Begun at this time or later (ISO 8601 or a date)");
  table.option("--to", asked->to, "Begun before this time");
  table.option("--machine", asked->machine, "Only this machine");
  table.option("-o,--output", asked->output, "File to write (standard output when left out)");
  verb(ports, context, asked, "certificate", "What is known of one transfer", [](Context& to, Connection& server, const Asked& given) {
    const auto one = server.get("/port-transfers/" + std::to_string(given.id));
    show(to, one, one.dump(2));
  }).option("TRANSFER", asked->id, "Number of the transfer").required();
  verb(ports, context, asked, "tail", "The last characters that really went out of a transfer", tail)
      .option("TRANSFER", asked->id, "Number of the transfer").required();
  auto sets = verb(ports, context, asked, "data", "Machine data that controls have punched; with ID the values and what changed", data);
  sets.option("ID", asked->id, "Number of a set");
  sets.option("--machine", asked->machine, "Only this machine");
  sets.option("--kind", asked->kind, "tool_offsets, work_offsets, parameters, pitch_error, macro_variables, tool_life");
}

}  // namespace headstock::client
