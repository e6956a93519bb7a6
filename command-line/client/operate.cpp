// headstock run, hold, reset, drip, watch: what moves machines, and what shows them moving.

#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include "command-line/client/client.hpp"
#include "command-line/client/output.hpp"
#include "protocol/process/options.hpp"

namespace headstock::client {

namespace {

struct RunFields {
  std::string machine, program;
  int revision = 0;
  bool wait = false;
  int events = 0;
};

std::string stem(const std::string& name) { return name.substr(0, name.rfind('.')); }

/// The resident program meant by a name, a name without its ending, or a program of the library.
std::string resident_name(Connection& server, const std::string& machine, const std::string& wanted) {
  const auto census = server.get("/machines/" + machine + "/programs").at("items");
  const auto base = wanted.substr(wanted.rfind('/') == std::string::npos ? 0 : wanted.rfind('/') + 1);
  for (const auto& program : census)
    if (program.value("name", std::string()) == base) return base;
  for (const auto& program : census) {
    const auto name = program.value("name", std::string());
    if (stem(name) == base || name == stem(base) || program.at("program_id").dump() == wanted) return name;
  }
  throw Failure(refused, base + say(" is not in the machine's memory; send it first: headstock programs send ", " 不在机床存储器中；请先发送：headstock programs send ") + wanted);
}

/// Newest run of the machine; null when there was none.
json newest_run(Connection& server, const std::string& machine) {
  const auto runs = server.get("/machines/" + machine + "/runs?limit=1").at("items");
  return runs.empty() ? json(nullptr) : runs.front();
}

void run(Context& context, const RunFields& fields) {
  auto server = context.connect();
  const auto machine = find_machine(server, fields.machine).at("id").dump();
  const auto name = resident_name(server, machine, fields.program);
  const auto before = newest_run(server, machine);
  server.send("POST", "/machines/" + machine + "/select", {{"name", name}});
  auto answer = server.send("POST", "/machines/" + machine + "/commands", {{"action", "cycle_start"}});
  if (!fields.wait) {
    show(context, answer, say("cycle start: ", "循环启动：") + name);
    return;
  }
  const auto newer = [&](const json& latest) {
    return latest.is_object() && (before.is_null() || latest.at("id") != before.at("id"));
  };
  json last;
  do {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    last = newest_run(server, machine);
  } while (!newer(last) || last.at("ended").is_null());
  const auto outcome = last.value("outcome", std::string());
  if (outcome != "completed") context.status = refused;
  show(context, last, name + ": " + (outcome == "completed" ? say("completed", "完成") : outcome) + ", " + duration(last.at("run_s")));
}

void command(const Context& context, const RunFields& fields, const char* action) {
  auto server = context.connect();
  const auto machine = find_machine(server, fields.machine).at("id").dump();
  const auto answer = server.send("POST", "/machines/" + machine + "/commands", {{"action", action}});
  show(context, answer, say("accepted", "已接受"));
}

void drip(Context& context, const RunFields& fields) {
  auto server = context.connect();
  const auto machine = find_machine(server, fields.machine).at("id").dump();
  const auto program = find_program(server, fields.program);
  if (fields.revision == 0 && !program.at("released").is_object())
    throw Failure(refused, say("the program is not released", "程序尚未发布"));
  const json revision = fields.revision > 0 ? json(fields.revision) : program["released"].at("number");
  auto transfer = server.send("POST", "/machines/" + machine + "/drip", {{"program_id", program.at("id")}, {"revision", revision}});
  const auto over = [](const json& now) {
    const auto state = now.value("state", std::string());
    return state == "done" || state == "failed" || state == "cancelled";
  };
  while (fields.wait && !over(transfer)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    transfer = server.get("/transfers/" + transfer.at("id").dump());
    if (!context.as_json) std::cerr << "\r" << cell(transfer.at("bytes")) << "/" << cell(transfer.at("total")) << std::flush;
  }
  if (fields.wait && !context.as_json) std::cerr << "\n";
  if (fields.wait && transfer.value("state", std::string()) != "done") context.status = refused;
  show(context, transfer, say("transfer ", "传输 ") + transfer.at("id").dump() + ": " + cell(transfer.at("state")) +
                              (transfer.at("reason").is_null() ? "" : " (" + cell(transfer["reason"]) + ")"));
}

std::string live_line(const json& live) {
  const json program = live.value("program", json()), parts = live.value("parts", json());
  std::string text = cell(live.value("name", json())) + "  " + state_word(live.value("state", std::string("unknown")));
  if (program.is_object()) text += "  " + cell(program.value("name", json()));
  if (live.value("line", json()).is_number()) text += ":" + live["line"].dump();
  if (live.value("block", json()).is_string()) text += "  " + live["block"].get<std::string>();
  if (live.value("progress", json()).is_number()) text += "  " + std::to_string(static_cast<int>(live["progress"].get<double>() * 100)) + " %";
  if (parts.is_object()) text += say("  parts ", "  件数 ") + cell(parts.value("count", json()));
  const auto alarms = live.value("alarms", json());
  if (alarms.is_array())
    for (const auto& alarm : alarms) text += "  " + cell(alarm.value("code", json())) + " " + text_of(alarm.value("text", json()));
  return text;
}

void watch(const Context& context, const RunFields& fields) {
  auto server = context.connect();
  json topics = json::array({"transfers"});
  if (fields.machine.empty())
    topics.push_back("floor");
  else
    topics.push_back("machine:" + find_machine(server, fields.machine).at("id").dump());
  int left = fields.events;
  server.watch({{"subscribe", topics}}, [&](const json& message) {
    const auto type = message.value("type", std::string());
    if (type == "tick") return true;
    if (context.as_json) {
      std::cout << message.dump() << std::endl;
    } else if (type == "snapshot") {
      for (const auto& live : message.at("machines")) std::cout << live_line(live) << "\n";
      std::cout.flush();
    } else if (type == "live") {
      std::cout << live_line(message.at("live")) << std::endl;
    } else {
      std::cout << type << "  " << message.dump() << std::endl;
    }
    return fields.events == 0 || --left > 0;
  });
}

}  // namespace

void add_operate_commands(options::Command app, Context& context) {
  const auto fields = std::make_shared<RunFields>();
  const auto add = [&](const char* name, const char* about, auto body) {
    auto added = app.add_command(name, about);
    added.callback([&context, fields, body] { guarded(context, [&] { body(context, *fields); }); });
    return added;
  };
  auto start = add("run", "Select a resident program and press cycle start (remote operation must be armed at the machine)", run);
  start.option("MACHINE", fields->machine).required();
  start.option("PROGRAM", fields->program, "Name in the machine's memory").required();
  start.flag("--wait", fields->wait, "Until the run has ended; exit status 2 unless it was completed");
  add("hold", "Feed hold", [](Context& c, const RunFields& f) { command(c, f, "feed_hold"); })
      .option("MACHINE", fields->machine).required();
  add("reset", "Reset: ends the program and clears alarms", [](Context& c, const RunFields& f) { command(c, f, "reset"); })
      .option("MACHINE", fields->machine).required();
  auto feed = add("drip", "Drip-feed a released program that is larger than the machine's memory", drip);
  feed.option("MACHINE", fields->machine).required();
  feed.option("PROGRAM", fields->program).required();
  feed.option("--revision", fields->revision).positive();
  feed.flag("--wait", fields->wait, "Until it is over; exit status 2 unless done");
  auto live = add("watch", "Live states and events, until interrupted", watch);
  live.option("MACHINE", fields->machine, "Only this machine");
  live.option("--events", fields->events, "Stop after so many messages");
}

}  // namespace headstock::client
