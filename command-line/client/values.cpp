// headstock offsets, tool-life, parameters, variables, recount, orders.

#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>

#include "command-line/client/client.hpp"
#include "command-line/client/output.hpp"
#include "protocol/process/options.hpp"

namespace headstock::client {

namespace {

struct ValueFields {
  std::string machine, what, value, file, why, other, at, name, kind;
  std::int64_t id = 0, snapshot = 0;
  bool yes = false;
};
using SharedValueFields = std::shared_ptr<ValueFields>;

std::string machine_path(Connection& server, const std::string& machine) {
  return "/machines/" + find_machine(server, machine).at("id").dump();
}

std::string state_of(const json& request) {
  struct Word {
    const char *key, *en, *zh;
  };
  static constexpr Word kWords[] = {{"done", "written and read back", "已写入并回读确认"},
                                    {"waiting", "waits for a second person", "等待另一人确认"},
                                    {"unknown", "the answer was lost; the machine's next report will tell",
                                     "应答丢失，以机床下次上报为准"},
                                    {"withdrawn", "withdrawn", "已撤回"},
                                    {"refused", "refused", "被拒绝"},
                                    {"failed", "failed", "失败"},
                                    {"sending", "under way", "进行中"}};
  const auto state = request.value("state", std::string());
  for (const Word& word : kWords)
    if (state == word.key) return say(word.en, word.zh);
  return state;
}

std::string item_table(const json& items) {
  std::vector<Line> rows;
  for (const auto& item : items) {
    Line row = {cell(item.at("what")), cell(item.at("before")), cell(item.at("after"))};
    row.push_back(item.contains("problem") && item["problem"].is_string()
                      ? item["problem"].get<std::string>() + " (" + item.value("text", "") + ")"
                      : "");
    rows.push_back(std::move(row));
  }
  return table({say("value", "数据"), say("now", "当前"), say("new", "新值"), ""}, rows);
}

void show_request(const Context& context, const json& request) {
  show(context, request, say("request ", "请求 ") + request.at("id").dump() + ": " + state_of(request));
}

/// What was shown is what is sent: each value goes with the one it replaces.
void write(Context& context, Connection& server, const std::string& path, const json& items, const char* origin,
           const ValueFields& fields) {
  json values = json::array();
  for (const auto& item : items)
    values.push_back({{"what", item.at("what")}, {"before", item.at("before")}, {"after", item.at("after")}});
  if (values.empty()) return show(context, {{"changed", 0}}, say("nothing differs", "没有差异"));
  if (!fields.yes) {
    std::cerr << item_table(items) << say("These values would be written. Add --yes to write them.\n",
                                          "将写入以上数据。加 --yes 执行。\n");
    if (context.as_json) show(context, {{"changed", 0}, {"would_change", values.size()}}, "");
    return;
  }
  show_request(context, server.send("POST", path + "/values",
                                    {{"values", values}, {"origin", origin}, {"why", fields.why}}));
}

json now_of(Connection& server, const std::string& path, const std::string& what) {
  const auto values = server.get(path + "/values").at("values");
  if (values.contains(what)) return values.at(what);
  const bool zero = what.rfind("tool/", 0) == 0 || what.rfind("work/", 0) == 0;
  return zero ? json(0) : json(nullptr);
}

std::string read_file(const std::string& file) {
  if (file == "-") return {std::istreambuf_iterator<char>(std::cin), {}};
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Failure(usage, say("cannot read ", "无法读取 ") + file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Import of a table: nothing is written while anything in it is wrong.
void import(Context& context, const ValueFields& fields) {
  auto server = context.connect();
  const auto path = machine_path(server, fields.machine);
  const auto sheet = server.send("POST", path + "/values/sheet", {{"text", read_file(fields.file)}});
  json wrong = json::array();
  for (const auto& row : sheet.at("items"))
    if (!row.at("problem").is_null()) wrong.push_back(row);
  if (!wrong.empty())
    throw Failure(refused, say("nothing was written; these cells are wrong:\n", "未写入任何数据；以下单元格有误：\n") +
                               item_table(wrong), sheet);
  write(context, server, path, sheet.at("items"), "import", fields);
}

void difference(Context& context, const ValueFields& fields, const char* origin, const std::string& query) {
  auto server = context.connect();
  const auto path = machine_path(server, fields.machine);
  std::string asked = query;
  if (!fields.other.empty()) asked = "machine=" + find_machine(server, fields.other).at("id").dump();
  const auto found = server.get(path + "/values/difference?kind=" + fields.kind + "&" + asked);
  if (origin == nullptr) return show(context, found, item_table(found.at("items")));
  write(context, server, path, found.at("items"), origin, fields);
}

void history(Context& context, const ValueFields& fields) {
  auto server = context.connect();
  const auto changes = server.get(machine_path(server, fields.machine) + "/value-changes?what=" + encoded(fields.what));
  std::vector<Line> rows;
  for (const auto& one : changes.at("items"))
    rows.push_back({local_time(one.at("at")), cell(one.at("what")), cell(one.at("before")), cell(one.at("after")),
                    cell(one.at("origin")), cell(one.at("by"))});
  show(context, changes,
       table({say("time", "时间"), say("value", "数据"), say("before", "之前"), say("after", "之后"), say("by what", "方式"),
              say("who", "人员")}, rows));
}

void list_values(Context& context, const ValueFields& fields) {
  auto server = context.connect();
  const auto found = server.get(machine_path(server, fields.machine) + "/values?kind=" + fields.kind);
  std::vector<Line> rows;
  for (const auto& [what, value] : found.at("values").items()) rows.push_back({what, value.dump()});
  show(context, found, table({say("value", "数据"), ""}, rows));
}

/// list, get, set, history, export, import, diff, copy, restore: the same for every kind of page.
options::Command add_page(options::Command app, Context& context, const char* name, const char* about, const char* kind) {
  const auto fields = std::make_shared<ValueFields>();
  fields->kind = kind;
  auto page = app.add_command(name, about);
  page.requires_command();
  const auto sub = [&](const char* verb, const char* text, std::function<void()> body) {
    auto made = page.add_command(verb, text);
    made.option("MACHINE", fields->machine, "name or number").required();
    made.callback([&context, body = std::move(body)] { guarded(context, body); });
    return made;
  };
  sub("list", "What is set", [&context, fields] { list_values(context, *fields); });
  sub("history", "Every change, newest first", [&context, fields] { history(context, *fields); })
      .option("VALUE", fields->what, "tool/3/wear/X; tool/3/ for all of it");
  auto set = sub("set", "Write one value: seen, written, read back", [&context, fields] {
    auto server = context.connect();
    const auto path = machine_path(server, fields->machine);
    const json before = now_of(server, path, fields->what);
    json after = nullptr;
    if (fields->value != "none") {
      std::size_t read = 0;
      try {
        after = std::stod(fields->value, &read);
      } catch (const std::exception&) {
        read = 0;
      }
      if (read != fields->value.size()) throw Failure(usage, say("this is no number: ", "不是数字：") + fields->value);
      if (fields->value[0] == '+') after = before.is_number() ? before.get<double>() + after.get<double>() : after.get<double>();
    }
    fields->yes = true;
    write(context, server, path, json::array({{{"what", fields->what}, {"before", before}, {"after", after}}}), "person", *fields);
  });
  set.option("VALUE", fields->what, "tool/3/wear/X, work/G54/Z, parameter/6713, variable/500, tool_life/1/used/0").required();
  set.option("NUMBER", fields->value, "+0.02 adds; none erases a parameter or variable").required();
  set.option("--why", fields->why, "Kept with the change");
  auto out = sub("export", "As CSV", [&context, fields] {
    auto server = context.connect();
    const auto path = machine_path(server, fields->machine) + "/values/sheet?kind=" + fields->kind;
    std::ofstream file;
    if (!fields->file.empty()) file.open(fields->file, std::ios::binary | std::ios::trunc);
    std::ostream& to = fields->file.empty() ? std::cout : file;
    server.download(path, [&to](const char* bytes, std::size_t count) { to.write(bytes, static_cast<std::streamsize>(count)); });
    if (!to.flush()) throw Failure(usage, say("cannot write ", "无法写入 ") + fields->file);
  });
  out.option("--out", fields->file, "File; otherwise the terminal");
  auto in = sub("import", "From CSV or a pasted table", [&context, fields] { import(context, *fields); });
  in.option("FILE", fields->file, "- for standard input").required();
  auto diff = sub("diff", "What differs from another machine, a moment or a snapshot", [&context, fields] {
    difference(context, *fields, nullptr, fields->snapshot != 0 ? "snapshot=" + std::to_string(fields->snapshot) : "at=" + encoded(fields->at));
  });
  auto copy = sub("copy", "Make it as another machine's", [&context, fields] { difference(context, *fields, "copy", ""); });
  copy.option("FROM", fields->other, "the other machine").required();
  auto restore = sub("restore", "Make it as it was", [&context, fields] {
    difference(context, *fields, "restore", fields->snapshot != 0 ? "snapshot=" + std::to_string(fields->snapshot) : "at=" + encoded(fields->at));
  });
  diff.option("--machine", fields->other);
  for (auto one : {diff, restore}) {
    one.option("--at", fields->at, "2026-01-31T08:00Z");
    one.option("--snapshot", fields->snapshot, "number");
  }
  for (auto one : {in, copy, restore}) {
    one.flag("--yes", fields->yes, "Write; without it the changes are only shown");
    one.option("--why", fields->why, "Kept with the change");
  }
  return page;
}

void add_requests(options::Command offsets, Context& context) {
  const auto fields = std::make_shared<ValueFields>();
  offsets.add_command("requests", "What waits for a second person").callback([&context] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto requests = server.get("/value-requests?state=waiting");
      std::vector<Line> rows;
      for (const auto& one : requests.at("items"))
        rows.push_back({cell(one.at("id")), cell(one.at("machine")), cell(one.at("by")), local_time(one.at("at")), cell(one.at("needs_second"))});
      show(context, requests, table({say("request", "请求"), say("machine", "机床"), say("by", "申请人"), say("time", "时间"), say("value", "数据")}, rows));
    });
  });
  for (const auto& [verb, text] : {std::pair{"agree", "Agree as the second person: it is written now"}, std::pair{"withdraw", "It is not written"}}) {
    auto made = offsets.add_command(verb, text);
    made.option("REQUEST", fields->id).required();
    made.callback([&context, fields, verb = std::string(verb)] {
      guarded(context, [&] {
        auto server = context.connect();
        show_request(context, server.send("POST", "/value-requests/" + std::to_string(fields->id) + "/" + verb));
      });
    });
  }
  auto snapshot = offsets.add_command("snapshot", "Keep everything a machine has now under a name");
  snapshot.option("MACHINE", fields->machine).required();
  snapshot.option("NAME", fields->name).required();
  snapshot.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto made = server.send("POST", machine_path(server, fields->machine) + "/snapshots", {{"name", fields->name}});
      show(context, made, say("snapshot ", "快照 ") + made.at("id").dump());
    });
  });
  auto limit = offsets.add_command("limit", "The largest step one person may make (shop, or a machine)");
  limit.option("KIND", fields->kind, "wear geometry radius work variable parameter tool_life").required();
  limit.option("STEP", fields->value, "a number; none: any step").required();
  limit.option("--machine", fields->machine);
  limit.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto path = fields->machine.empty() ? std::string() : machine_path(server, fields->machine);
      const json step = fields->value == "none" ? json(nullptr) : json::parse(fields->value, nullptr, false);
      const auto limits = server.send("PATCH", path + "/value-limits", {{fields->kind, step}});
      show(context, limits, limits.dump());
    });
  });
}

void add_tool_life_list(options::Command life, Context& context) {
  life.add_command("left", "Life left and when the next change comes, in the whole shop").callback([&context] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto found = server.get("/tool-life");
      std::vector<Line> rows;
      for (const auto& one : found.at("items"))
        rows.push_back({cell(one.at("machine_name")), cell(one.at("group")), cell(one.at("life")) + " " + one.at("unit").get<std::string>(),
                        cell(one.at("left_current")), cell(one.at("left_total")), cell(one.at("parts_left")),
                        one.at("change_due").get<bool>() ? say("now", "现在") : duration(one.at("next_change_s"))});
      show(context, found,
           table({say("machine", "机床"), say("group", "组"), say("life", "寿命"), say("left (tool)", "当前刀具剩余"),
                  say("left (group)", "本组剩余"), say("parts left", "剩余件数"), say("next change in", "下次换刀")}, rows));
    });
  });
}

}  // namespace

void add_value_commands(options::Command app, Context& context) {
  const auto offsets = add_page(app, context, "offsets", "Tool offsets: list, set, history, export, import, diff, copy, restore …", "offsets");
  add_page(app, context, "work-offsets", "Work offsets: G54-G59, G54.1, external, shift", "work");
  const auto tool_life = add_page(app, context, "tool-life", "Tool life: left, list, set …", "tool_life");
  add_page(app, context, "parameters", "Parameters: list, set, diff, restore …", "parameters");
  add_page(app, context, "variables", "Common macro variables: list, set …", "variables");
  add_requests(offsets, context);
  add_tool_life_list(tool_life, context);
  const auto fields = std::make_shared<ValueFields>();
  auto recount = app.add_command("recount", "Part counts and runs made again from the raw events; exit 2 when they differ");
  recount.option("MACHINE", fields->machine, "all unless told");
  recount.callback([&context, fields] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto query = fields->machine.empty() ? std::string() : "?machine=" + find_machine(server, fields->machine).at("id").dump();
      const auto found = server.get("/counts/recount" + query);
      std::vector<Line> rows;
      bool identical = true;
      for (const auto& one : found.at("items")) {
        identical &= one.at("identical").get<bool>();
        rows.push_back({cell(one.at("machine_name")), cell(one.at("events")), cell(one.at("missing")), cell(one.at("parts")), cell(one.at("parts_stored")),
                        cell(one.at("runs")), cell(one.at("runs_stored")), one.at("identical").get<bool>() ? say("identical", "一致") : one.at("differences").dump()});
      }
      show(context, found,
           table({say("machine", "机床"), say("events", "事件"), say("never came", "缺失"), say("parts", "件数"), say("stored", "已存"),
                  say("runs", "运行"), say("stored", "已存"), ""}, rows));
      if (!identical) context.status = refused;
    });
  });
}

}  // namespace headstock::client
