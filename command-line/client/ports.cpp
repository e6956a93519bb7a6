// headstock ports: serial ports of the server, what goes over them, what came back.

#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <thread>

#include "command-line/client/client.hpp"
#include "command-line/client/output.hpp"
#include "protocol/process/options.hpp"

namespace headstock::client {

namespace {

struct Fields {
  std::string port, name, address, machine, protocol, line, folder, program, header, why, settings, at, name_rule;
  std::vector<std::string> rules;
  std::int64_t revision = 0, from_line = 0, from_block = 0, from_sequence = -1, from_tool = 0, occurrence = 1, id = 0;
  bool listen = false, no_listen = false, drip = false, queue = false, armed = false, wait = false, yes = false, follow = false, write = false;
};

json find_port(Connection& server, const std::string& wanted) {
  const auto ports = server.get("/ports").at("items");
  for (const auto& port : ports)
    if (port.at("name") == wanted || port.at("id").dump() == wanted) return port;
  throw Failure(usage, say("no port ", "没有端口 ") + wanted);
}

std::string path_of(const json& port, const std::string& verb = "") {
  std::string path = "/ports/" + port.at("id").dump();
  if (!verb.empty()) path.append("/").append(verb);
  return path;
}

std::string progress_of(const json& transfer) {
  if (!transfer.is_object()) return "–";
  std::string text = cell(transfer.at("name")) + " " + cell(transfer.at("state")) + " " + cell(transfer.at("bytes"));
  if (!transfer.at("total").is_null()) text.append("/").append(cell(transfer.at("total")));
  return text;
}

std::string port_table(const json& ports) {
  std::vector<Line> rows;
  for (const auto& port : ports)
    rows.push_back({cell(port.at("id")), cell(port.at("name")), cell(port.at("address")),
                    cell(port.at("settings").at("protocol")), cell(port.at("settings").at("line")), cell(port.at("state")),
                    cell(port.at("reason")), progress_of(port.at("transfer"))});
  return table({say("id", "编号"), say("name", "名称"), say("address", "地址"), say("protocol", "协议"), say("line", "线路"),
                say("state", "状态"), say("reason", "原因"), say("transfer", "传输")},
               rows);
}

json fields_of(Connection& server, const Fields& given) {
  json body = json::object();
  if (!given.name.empty()) body["name"] = given.name;
  if (!given.address.empty()) body["address"] = given.address;
  if (!given.machine.empty()) body["machine"] = find_machine(server, given.machine).at("id");
  if (!given.folder.empty()) body["folder"] = given.folder;
  if (!given.name_rule.empty()) body["name_rule"] = given.name_rule;
  if (given.listen) body["listens"] = true;
  if (given.no_listen) body["listens"] = false;
  for (const auto& rule : given.rules) {
    // PATTERN:NAME, as "(GET=*):O*"; without * it asks for the list
    const auto colon = rule.rfind(':');
    if (colon == std::string::npos) throw Failure(usage, say("a rule is PATTERN:NAME, as ", "规则格式为 模式:名称，如 ") + "'(GET=*):O*'");
    const bool list = rule.find('*') == std::string::npos;
    body["rules"].push_back({{"pattern", rule.substr(0, colon)}, {"name", rule.substr(colon + 1)}, {"action", list ? "list" : "send"}});
  }
  json settings = json::object();
  if (!given.settings.empty()) {
    settings = json::parse(given.settings, nullptr, false);
    if (!settings.is_object()) throw Failure(usage, say("--settings is a JSON object", "--settings 须为 JSON 对象"));
  }
  if (!given.protocol.empty()) settings["protocol"] = given.protocol;
  if (!given.line.empty()) settings["line"] = given.line;
  if (!settings.empty()) body["settings"] = settings;
  return body;
}

/// Waits for the end of a transfer, telling each change of state. @return its last record.
json wait_for(Connection& server, std::int64_t port, std::int64_t id) {
  std::string told;
  for (;;) {
    const auto list = server.get("/port-transfers?limit=50&port=" + std::to_string(port)).at("items");
    for (const auto& transfer : list) {
      if (transfer.at("id") != id) continue;
      const auto now = progress_of(transfer);
      if (now != told) std::cerr << (told = now) << '\n';
      if (!transfer.at("ended").is_null()) return transfer;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
}

void finish(Context& context, const json& transfer) {
  show(context, transfer, progress_of(transfer) + (transfer.at("reason").is_null() ? "" : " " + cell(transfer.at("reason"))));
  if (transfer.at("state") != "done") context.status = refused;
}

/// Where to begin, as the person named it; null: at the beginning.
json place_of(const Fields& given) {
  json place = nullptr;
  if (given.from_line > 1) place["line"] = given.from_line;
  if (given.from_block > 0) place["block"] = given.from_block;
  if (given.from_sequence >= 0) place["sequence"] = given.from_sequence;
  if (given.from_tool > 0) place["tool"] = given.from_tool;
  if (place.is_object() && place.size() > 1) throw Failure(usage, say("one --from… at a time", "只能指定一个 --from…"));
  if (place.is_object()) place["occurrence"] = given.occurrence;
  return place;
}

void send(Context& context, const Fields& given) {
  auto server = context.connect();
  const auto port = find_port(server, given.port);
  const auto program = find_program(server, given.program);
  if (given.revision == 0 && program.at("released").is_null())
    throw Failure(refused, say("not released: ", "尚未发布：") + given.program);
  json body = {{"program", program.at("id")},
               {"revision", given.revision != 0 ? json(given.revision) : program.at("released").at("number")},
               {"drip", given.drip}};
  json place = place_of(given);
  if (!place.is_null()) {
    place["program"] = body["program"];
    place["revision"] = body["revision"];
    const auto asked = server.send("POST", path_of(port, "restart"), place);
    body["from_line"] = asked.at("line");
    std::cerr << say("From line ", "起始行 ") << asked.at("line") << ": " << asked.at("text").get<std::string>() << "\n";
    if (asked.at("occurrences").get<std::int64_t>() > 1)
      std::cerr << say("There are ", "共有 ") << asked.at("occurrences") << say(" such places; choose with --occurrence\n", " 处；用 --occurrence 选择\n");
    if (given.header.empty()) {
      if (!asked.at("error").is_null())
        throw Failure(refused, text_of(asked.at("error").at("message")) + " " + cell(asked.at("error").at("where")), asked);
      std::cerr << say("This will be sent first. Read every block:\n", "将先发送以下内容，请逐段核对：\n")
                << asked.at("header").get<std::string>();
      if (!given.yes)
        throw Failure(refused, say("nothing was sent; save it to a file, correct it, and give it with --header FILE, or confirm with --yes",
                                   "未发送；请存为文件修改后用 --header FILE 提供，或用 --yes 确认"));
      body["header"] = asked.at("header");
    } else {
      std::ifstream in(given.header, std::ios::binary);
      if (!in) throw Failure(usage, say("cannot read ", "无法读取 ") + given.header);
      body["header"] = std::string(std::istreambuf_iterator<char>(in), {});
    }
  }
  if (!given.at.empty()) {
    body["at"] = given.at;
    const auto plan = server.send("POST", path_of(port, "plans"), body);
    return show(context, plan, say("plan ", "计划 ") + cell(plan.at("id")) + ": " + cell(plan.at("name")) + " " + local_time(plan.at("at")));
  }
  body["queue"] = given.queue;
  body["armed"] = given.armed;
  const auto transfer = server.send("POST", path_of(port, "send"), body);
  if (!given.wait) return show(context, transfer, progress_of(transfer));
  finish(context, wait_for(server, port.at("id"), transfer.at("id")));
}

void monitor(Context& context, const Fields& given) {
  auto server = context.connect();
  const auto port = find_port(server, given.port);
  std::int64_t shown = 0;
  do {
    const auto piece = server.get(path_of(port, "monitor?limit=1000&after=" + std::to_string(shown)));
    const auto& items = piece.at("items");
    // The newest entry may still grow: it is shown when another has begun, or at the end.
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (given.follow && items[i].at("sequence") == piece.at("last") && items[i].at("hex").is_string()) break;
      shown = items[i].at("sequence");
      if (context.as_json) std::cout << items[i].dump() << '\n';
      else std::cout << local_time(items[i].at("at")) << ' ' << cell(items[i].at("kind")) << ' ' << cell(items[i].at("text")) << '\n';
    }
    std::cout << std::flush;
    if (given.follow) std::this_thread::sleep_for(std::chrono::milliseconds(300));
  } while (given.follow);
}

template <class Do>
void command(options::Command app, Context& context, const std::shared_ptr<Fields>& fields, const char* verb, const char* about, Do action,
             bool needs_port = true) {
  auto made = app.add_command(verb, about);
  if (needs_port) made.option("PORT", fields->port, "Number or name").required();
  action.options(made);
  made.callback([&context, fields, run = action.run] { guarded(context, [&] { run(context, *fields); }); });
}

struct Verb {
  std::function<void(options::Command)> options = [](options::Command) {};
  std::function<void(Context&, const Fields&)> run;
};

Verb steering(const char* verb) {
  return {[](options::Command) {}, [verb](Context& context, const Fields& given) {
            auto server = context.connect();
            const auto port = server.send("POST", path_of(find_port(server, given.port), verb));
            show(context, port, port_table(json::array({port})));
          }};
}

Verb deciding(const char* verb, const std::shared_ptr<Fields>& fields) {
  return {[fields](options::Command made) {
            made.option("ID", fields->id, "Number of what was received").required();
            made.option("--why", fields->why, "Reason");
          },
          [verb](Context& context, const Fields& given) {
            auto server = context.connect();
            const auto row = server.send("POST", "/received/" + std::to_string(given.id) + "/" + verb, {{"why", given.why}});
            show(context, row, cell(row.at("name")) + " " + cell(row.at("state")));
          }};
}

/// What became of machine data: "3 written, 1 without a place".
std::string outcome_of(const json& row) {
  const auto values = row.find("values");
  if (values == row.end() || !values->is_object()) return "";
  std::string text;
  const auto add = [&](const char* what, const std::string& words) {
    if (values->at(what) != 0) text.append(text.empty() ? ": " : ", ").append(cell(values->at(what))).append(words);
  };
  add("written", say(" values written down", " 个值已记录"));
  add("differ", say(" differ in the machine", " 个值与机床不同"));
  add("same", say(" as known", " 个值相同"));
  add("without_place", say(" kept in the set only", " 个值仅保存在数据集中"));
  if (!values->at("request").is_null())
    text.append("; ").append(say("request ", "请求 ")).append(cell(values->at("request"))).append(" ").append(cell(values->at("request_state")));
  if (!values->at("request_reason").is_null()) text.append(" ").append(cell(values->at("request_reason")));
  return text;
}

Verb accepting(const std::shared_ptr<Fields>& fields) {
  Verb verb = deciding("accept", fields);
  const auto options = verb.options;
  verb.options = [fields, options](options::Command made) {
    options(made);
    made.flag("--write", fields->write, "Machine data of a machine with an agent: write what differs into it");
  };
  verb.run = [](Context& context, const Fields& given) {
    auto server = context.connect();
    const auto row = server.send("POST", "/received/" + std::to_string(given.id) + "/accept", {{"why", given.why}, {"write", given.write}});
    show(context, row, cell(row.at("name")) + " " + cell(row.at("state")) + outcome_of(row));
  };
  return verb;
}

}  // namespace

void add_port_commands(options::Command app, Context& context) {
  const auto fields = std::make_shared<Fields>();
  auto ports = app.add_command("ports", "Serial ports of the server: list, add, send, receive, monitor …");
  ports.allows_command();
  const auto list = [&context] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto items = server.get("/ports").at("items");
      show(context, items, port_table(items));
    });
  };
  ports.callback([ports, list] {
    if (ports.alone()) list();
  });
  ports.add_command("list", "All ports and what they do").callback(list);
  const auto settings = [fields](options::Command made) {
    made.option("--address", fields->address, "/dev/ttyS0, tcp://HOST:PORT, rfc2217://HOST:PORT, agent:MACHINE");
    made.option("--machine", fields->machine, "What stands at the other end");
    made.option("--protocol", fields->protocol, "dc1-dc4, xon-xoff, plain, rts-cts, lathe-200t …");
    made.option("--line", fields->line, "9600-7-E-2-software");
    made.option("--settings", fields->settings, "Further settings as JSON");
    made.option("--folder", fields->folder, "Where received programs belong");
    made.option("--name-rule", fields->name_rule, "What received programs are called by: their O number or their comment")
        .one_of({"number", "comment"});
    made.option("--rule", fields->rules, "Answer requests: '(GET=*):O*', '(LIST):O9999'; may come several times");
    made.flag("--listen", fields->listen, "Keep the port open, take punches, answer requests");
    made.flag("--no-listen", fields->no_listen, "Open the port only for transfers");
  };
  Verb add{[fields, settings](options::Command made) {
             made.option("NAME", fields->name).required();
             settings(made);
           },
           [](Context& to, const Fields& given) {
             auto server = to.connect();
             const auto port = server.send("POST", "/ports", fields_of(server, given));
             show(to, port, port_table(json::array({port})));
           }};
  command(ports, context, fields, "add", "Add a port", add, false);
  Verb edit{[fields, settings](options::Command made) {
              made.option("--name", fields->name);
              settings(made);
            },
            [](Context& to, const Fields& given) {
              auto server = to.connect();
              const auto found = find_port(server, given.port);
              auto body = fields_of(server, given);
              if (body.contains("settings")) {
                json whole = found.at("settings");
                // Another protocol brings its own settings.
                if (!given.protocol.empty()) whole = json::object();
                whole.update(body["settings"]);
                body["settings"] = whole;
              }
              const auto port = server.send("PATCH", path_of(found), body);
              show(to, port, port_table(json::array({port})));
            }};
  command(ports, context, fields, "edit", "Change a port", edit);
  command(ports, context, fields, "remove", "Remove a port; its history stays",
          Verb{[](options::Command) {}, [](Context& to, const Fields& given) {
                 auto server = to.connect();
                 server.send("DELETE", path_of(find_port(server, given.port)), nullptr);
                 show(to, {{"removed", given.port}}, say("removed ", "已删除 ") + given.port);
               }});
  command(ports, context, fields, "send", "Send a released program",
          Verb{[fields](options::Command made) {
                 made.option("PROGRAM", fields->program, "Number, name or /folder/name").required();
                 made.option("--revision", fields->revision, "Released revision (the current release when left out)");
                 made.flag("--drip", fields->drip, "Drip-feed: the control may stop for as long as it likes");
                 made.flag("--queue", fields->queue, "Wait behind what is under way");
                 made.flag("--armed", fields->armed, "Wait for the control's DC1 without limit");
                 made.option("--at", fields->at, "Send at this time (2026-01-31T06:00:00Z), when the control asks");
                 made.option("--from-line", fields->from_line, "Begin at this line, behind a header").positive();
                 made.option("--from-block", fields->from_block, "Begin at this block, counted from 1").positive();
                 made.option("--from-sequence", fields->from_sequence, "Begin at this sequence number (N)").not_negative();
                 made.option("--from-tool", fields->from_tool, "Begin where it changes to this tool").positive();
                 made.option("--occurrence", fields->occurrence, "The n-th such place (1 when left out)").positive();
                 made.option("--header", fields->header, "File with the header you have read and corrected");
                 made.flag("--yes", fields->yes, "I have read the header that is shown");
                 made.flag("--wait", fields->wait, "Wait for the end");
               },
               send});
  command(ports, context, fields, "receive", "Wait for a punch",
          Verb{[](options::Command) {}, [](Context& to, const Fields& given) {
                 auto server = to.connect();
                 const auto transfer = server.send("POST", path_of(find_port(server, given.port), "receive"));
                 show(to, transfer, progress_of(transfer));
               }});
  command(ports, context, fields, "pause", "Stop sending until resumed", steering("pause"));
  command(ports, context, fields, "resume", "Go on sending", steering("resume"));
  command(ports, context, fields, "cancel", "End what is under way", steering("cancel"));
  command(ports, context, fields, "test", "Loop-back test with a plug that joins RXD and TXD",
          Verb{[](options::Command) {}, [](Context& to, const Fields& given) {
                 auto server = to.connect();
                 const auto report = server.send("POST", path_of(find_port(server, given.port), "loop-test"));
                 show(to, report, (report.at("ok") == true ? std::string("ok") : cell(report.at("reason"))) + ": " +
                                      cell(report.at("sent")) + " → " + cell(report.at("received")));
                 if (report.at("ok") != true) to.status = refused;
               }});
  command(ports, context, fields, "monitor", "What went over the line",
          Verb{[fields](options::Command made) { made.flag("-f,--follow", fields->follow, "Go on showing"); }, monitor});
  command(ports, context, fields, "history", "What went over a port, newest first",
          Verb{[](options::Command) {}, [](Context& to, const Fields& given) {
                 auto server = to.connect();
                 const auto items = server.get("/port-transfers?port=" + find_port(server, given.port).at("id").dump()).at("items");
                 std::vector<Line> rows;
                 for (const auto& row : items)
                   rows.push_back({cell(row.at("id")), local_time(row.at("created")), cell(row.at("kind")), cell(row.at("name")),
                                   cell(row.at("revision")), cell(row.at("bytes")), cell(row.at("state")), cell(row.at("reason")),
                                   cell(row.at("by")), cell(row.at("wire_sha256")).substr(0, 12)});
                 show(to, items, table({say("id", "编号"), say("time", "时间"), say("kind", "类型"), say("name", "名称"),
                                        say("revision", "版本"), say("bytes", "字节"), say("state", "状态"), say("reason", "原因"),
                                        say("by", "操作者"), "sha256"}, rows));
               }});
  add_port_record_commands(ports, context);
  auto received = app.add_command("received", "What controls have punched: list, accept, reject");
  received.allows_command();
  received.callback([received, &context] {
    if (!received.alone()) return;
    guarded(context, [&] {
      auto server = context.connect();
      const auto items = server.get("/received").at("items");
      std::vector<Line> rows;
      for (const auto& row : items)
        rows.push_back({cell(row.at("id")), local_time(row.at("at")), cell(row.at("kind")), cell(row.at("name")), cell(row.at("comment")),
                        cell(row.at("against_revision")), row.at("classes").dump(), cell(row.at("state"))});
      show(context, items, table({say("id", "编号"), say("time", "时间"), say("kind", "类型"), say("name", "名称"), say("comment", "注释"),
                                  say("against", "对比版本"), say("changes", "变化"), say("state", "状态")}, rows));
    });
  });
  command(received, context, fields, "accept", "Make it a new revision, from machine; machine data become values of its pages", accepting(fields), false);
  command(received, context, fields, "reject", "Put it aside; the library stays as it is", deciding("reject", fields), false);
}

}  // namespace headstock::client
