// headstock programs …

#include <fstream>
#include <iostream>
#include <memory>
#include <thread>

#include <unistd.h>

#include "command-line/client/client.hpp"
#include "command-line/client/output.hpp"
#include "protocol/process/options.hpp"

namespace headstock::client {

namespace {

struct ProgramFields {
  std::string program, file, folder = "/", note, name, machine, why, text, out;
  std::vector<std::string> machines;
  int revision = 0, from = 0, to = 0;
  bool wait = false, make = false, remove = false;
};
using Shared = std::shared_ptr<ProgramFields>;

/// The number asked for, otherwise the newest (or, where it matters, the released) revision.
std::string revision_of(const json& program, int asked, const char* otherwise) {
  if (asked > 0) return std::to_string(asked);
  const auto& revision = program.at(otherwise);
  if (!revision.is_object())
    throw Failure(refused, program.value("name", std::string()) + say(" is not released", " 尚未发布"));
  return revision.at("number").dump();
}

std::string program_path(const json& program) {
  const auto folder = program.value("folder", std::string("/"));
  return (folder == "/" ? "" : folder) + "/" + program.value("name", std::string());
}

std::string program_table(const json& programs) {
  std::vector<Line> rows;
  for (const auto& program : programs) {
    const auto &newest = program.at("newest"), &released = program.at("released");
    rows.push_back({cell(program.at("id")), program_path(program), newest.is_object() ? cell(newest.at("number")) : "–",
                    released.is_object() ? cell(released.at("number")) : "–", newest.is_object() ? cell(newest.at("bytes")) : "–",
                    newest.is_object() ? cell(newest.at("by")) : "–", newest.is_object() ? local_time(newest.at("at")) : "–"});
  }
  return table({say("id", "编号"), say("program", "程序"), say("newest", "最新"), say("released", "发布"), say("bytes", "字节"),
                say("by", "上传者"), say("at", "时间")},
               rows);
}

std::string transfer_table(const json& transfers) {
  std::vector<Line> rows;
  for (const auto& transfer : transfers)
    rows.push_back({cell(transfer.at("id")), cell(transfer.at("machine")), cell(transfer.at("state")),
                    cell(transfer.at("bytes")) + "/" + cell(transfer.at("total")), cell(transfer.at("reason"))});
  return table({say("transfer", "传输"), say("machine", "机床"), say("state", "状态"), say("bytes", "字节"), say("reason", "原因")}, rows);
}

void put(const Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  const auto name = fields.name.empty() ? std::filesystem::path(fields.file).filename().string() : fields.name;
  const bool bar = !context.as_json && ::isatty(STDERR_FILENO) != 0;
  int shown = -1;
  const auto progress = [&](std::uint64_t sent, std::uint64_t all) {
    const int percent = static_cast<int>(sent * 100 / all);
    if (!bar || percent == shown) return;
    shown = percent;
    std::cerr << "\r" << percent << " %" << (percent == 100 ? "\n" : "") << std::flush;
  };
  const auto answer = server.upload("/programs?folder=" + encoded(fields.folder) + "&name=" + encoded(name) + "&note=" + encoded(fields.note),
                                    fields.file, progress);
  const auto& revision = answer.at("revision");
  std::string text = program_path(answer.at("program")) + say(" revision ", " 版本 ") + cell(revision.at("number")) + ", " +
                     cell(revision.at("bytes")) + say(" bytes, SHA-256 ", " 字节，SHA-256 ") + cell(revision.at("sha256"));
  if (!answer.value("created", true)) text += say("\nthe same content as the newest revision: nothing was added", "\n内容与最新版本相同，未新增版本");
  if (answer.at("duplicate_of").is_object())
    text += say("\nthe same content as program ", "\n内容与程序 ") + answer["duplicate_of"].at("program").dump() + say(" revision ", " 版本 ") +
            answer["duplicate_of"].at("revision").dump() + (chinese() ? " 相同" : "");
  show(context, answer, text);
}

void get(const Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  const auto program = find_program(server, fields.program);
  const auto path = "/programs/" + program.at("id").dump() + "/revisions/" + revision_of(program, fields.revision, "newest") + "/content";
  if (fields.out.empty() || fields.out == "-") {
    server.download(path, [](const char* bytes, std::size_t count) { std::cout.write(bytes, static_cast<std::streamsize>(count)); });
    std::cout.flush();
    return;
  }
  // Whole or not at all: a cut download must not stand there under the file's name.
  const auto temporary = fields.out + ".part";
  std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
  if (!out) throw Failure(usage, say("cannot write ", "无法写入 ") + temporary);
  server.download(path, [&](const char* bytes, std::size_t count) { out.write(bytes, static_cast<std::streamsize>(count)); });
  out.close();
  if (!out) throw Failure(usage, say("cannot write ", "无法写入 ") + temporary);
  std::filesystem::rename(temporary, fields.out);
}

void list(const Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  json all = json::array();
  std::string cursor;
  do {
    const auto page = server.get("/programs?limit=1000" + (fields.folder.empty() ? "" : "&folder=" + encoded(fields.folder)) +
                                 (fields.text.empty() ? "" : "&q=" + encoded(fields.text)) + (cursor.empty() ? "" : "&cursor=" + cursor));
    for (const auto& program : page.at("items")) all.push_back(program);
    cursor = page.at("next").is_string() ? page.at("next").get<std::string>() : "";
  } while (!cursor.empty());
  show(context, all, program_table(all));
}

void revisions(const Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  const auto items = server.get("/programs/" + find_program(server, fields.program).at("id").dump() + "/revisions").at("items");
  std::vector<Line> rows;
  for (const auto& revision : items)
    rows.push_back({cell(revision.at("number")), cell(revision.at("bytes")), cell(revision.at("lines")), cell(revision.at("by")),
                    local_time(revision.at("at")), revision.at("released").is_object() ? say("released", "已发布") : "", cell(revision.at("note"))});
  show(context, items, table({say("revision", "版本"), say("bytes", "字节"), say("lines", "行"), say("by", "上传者"), say("at", "时间"), "", say("note", "说明")}, rows));
}

void diff(const Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  const auto program = find_program(server, fields.program);
  const int to = std::stoi(revision_of(program, fields.to, "newest"));
  const int from = fields.from > 0 ? fields.from : to - 1;
  const auto answer = finished(server, server.get("/programs/" + program.at("id").dump() + "/diff?context=3&from=" +
                                                  std::to_string(from) + "&to=" + std::to_string(to)));
  std::string text;
  for (const auto& row : answer.at("rows")) {
    const auto kind = row.value("kind", std::string());
    const auto label = row.at("class").is_string() ? "  [" + row["class"].get<std::string>() + "]" : "";
    if (kind == "same") text += "  " + cell(row.at("right")) + "\n";
    if (kind == "skipped") text += "…\n";
    if (kind == "removed" || kind == "changed") text += "- " + cell(row.at("left")) + (kind == "removed" ? label : "") + "\n";
    if (kind == "added" || kind == "changed") text += "+ " + cell(row.at("right")) + label + "\n";
  }
  if (answer.at("classes").empty()) text += say("no difference\n", "没有差异\n");
  show(context, answer, text);
}

void check(Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  const auto program = find_program(server, fields.program);
  const auto machine = find_machine(server, fields.machine);
  const auto answer = finished(server, server.send("POST", "/programs/" + program.at("id").dump() + "/revisions/" +
                                                               revision_of(program, fields.revision, "newest") + "/check",
                                                   {{"machine", machine.at("id")}}));
  std::string text;
  for (const auto& finding : answer.at("findings"))
    text += cell(program.at("name")) + ":" + cell(finding.at("line")) + ":" + cell(finding.at("column")) + ": " + cell(finding.at("code")) + " " +
            text_of(finding.at("text")) + "\n";
  const bool passed = answer.value("ok", false);
  text += (passed ? say("passed: ", "检查通过：") : say("not passed: ", "检查未通过：")) + duration(answer.at("time_s")) + say(", cutting ", "，切削 ") +
          duration(answer.at("cutting_s")) + say(" on ", "，机床 ") + cell(machine.at("name"));
  show(context, answer, text);
  if (!passed) context.status = refused;
}

void release(const Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  const auto program = find_program(server, fields.program);
  json body = {{"why", fields.why}};
  if (!fields.machine.empty()) body["machine"] = find_machine(server, fields.machine).at("id");
  const auto answer = server.send("POST", "/programs/" + program.at("id").dump() + "/revisions/" + revision_of(program, fields.revision, "newest") + "/release", body);
  show(context, answer, program_path(answer) + say(" revision ", " 版本 ") + answer.at("released").at("number").dump() + say(" is released", " 已发布"));
}

void withdraw(const Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  const auto program = find_program(server, fields.program);
  const auto answer = server.send("DELETE", "/programs/" + program.at("id").dump() + "/release", {{"why", fields.why}});
  show(context, answer, program_path(answer) + say(": the release is withdrawn", "：已撤销发布"));
}

bool all_over(const json& transfers) {
  for (const auto& transfer : transfers) {
    const auto state = transfer.value("state", std::string());
    if (state != "done" && state != "failed" && state != "cancelled") return false;
  }
  return true;
}

void send_to_machines(Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  const auto program = find_program(server, fields.program);
  json machines = json::array();
  for (const auto& machine : fields.machines) machines.push_back(find_machine(server, machine).at("id"));
  const auto revision = std::stoi(revision_of(program, fields.revision, "released"));
  auto answer = server.send("POST", "/distributions", {{"program", program.at("id")}, {"revision", revision}, {"machines", machines}});
  while (!all_over(answer.at("transfers"))) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    answer = server.get("/distributions/" + answer.at("id").dump());
  }
  for (const auto& transfer : answer.at("transfers"))
    if (transfer.value("state", std::string()) != "done") context.status = refused;
  show(context, answer, transfer_table(answer.at("transfers")));
}

void folders(const Context& context, const ProgramFields& fields) {
  auto server = context.connect();
  if (fields.make) server.send("POST", "/folders", {{"path", fields.folder}});
  if (fields.remove) server.send("DELETE", "/folders?path=" + encoded(fields.folder), nullptr);
  const auto items = server.get("/folders").at("items");
  std::string text;
  for (const auto& folder : items) text += cell(folder.at("path")) + "\n";
  show(context, items, text);
}

}  // namespace

void add_program_commands(options::Command app, Context& context) {
  auto programs = app.add_command("programs", "The library: put, get, list, revisions, diff, check, release, withdraw, send, folders");
  programs.requires_command();
  const auto command = [&](const char* name, const char* about, auto run) {
    auto added = programs.add_command(name, about);
    const auto fields = std::make_shared<ProgramFields>();
    added.callback([&context, fields, run] { guarded(context, [&] { run(context, *fields); }); });
    return std::pair{added, fields};
  };
  const auto program_option = [](options::Command to, const Shared& fields) {
    to.option("PROGRAM", fields->program, "Id, /FOLDER/NAME, or a name that only one program has").required();
    to.option("--revision", fields->revision, "Number of the revision").positive();
  };
  {
    auto [to, fields] = command("put", "Store a file: new, or a new revision of the program with its name", put);
    to.option("FILE", fields->file).required().existing_file();
    to.option("--folder", fields->folder).shows_default();
    to.option("--note", fields->note, "Why");
    to.option("--name", fields->name, "Another name than the file's");
  }
  {
    auto [to, fields] = command("get", "The exact bytes of a revision (the newest)", get);
    program_option(to, fields);
    to.option("-o,--out", fields->out, "File; stdout unless given");
  }
  {
    auto [to, fields] = command("list", "Programs with their newest and released revision", list);
    fields->folder.clear();
    to.option("--folder", fields->folder);
    to.option("--text", fields->text, "Part of the name");
  }
  {
    auto [to, fields] = command("revisions", "Every revision: who, when, why", revisions);
    program_option(to, fields);
  }
  {
    auto [to, fields] = command("diff", "Two revisions (the newest and the one before), each change classified", diff);
    to.option("PROGRAM", fields->program).required();
    to.option("--from", fields->from).positive();
    to.option("--to", fields->to).positive();
  }
  {
    auto [to, fields] = command("check", "Would this machine run it? Exit status 2 when not", check);
    program_option(to, fields);
    to.option("--machine", fields->machine).required();
  }
  {
    auto [to, fields] = command("release", "Make a checked revision the one that may be sent and run", release);
    program_option(to, fields);
    to.option("--why", fields->why).required();
    to.option("--machine", fields->machine, "Demand a passed check for this machine");
  }
  {
    auto [to, fields] = command("withdraw", "Withdraw the release", withdraw);
    to.option("PROGRAM", fields->program).required();
    to.option("--why", fields->why).required();
  }
  {
    auto [to, fields] = command("send", "Send the released revision to machines; a result for each", send_to_machines);
    program_option(to, fields);
    to.option("MACHINES", fields->machines, "Ids or names").required();
  }
  {
    auto [to, fields] = command("folders", "All folders; --make or --remove one", folders);
    to.option("FOLDER", fields->folder);
    to.flag("--make", fields->make);
    to.flag("--remove", fields->remove).excludes("--make");
  }
}

}  // namespace headstock::client
