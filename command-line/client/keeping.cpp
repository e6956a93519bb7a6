// audit, backup, view-tokens: what an administrator keeps the shop with.

#include <fstream>
#include <iostream>
#include <memory>

#include "command-line/client/client.hpp"
#include "command-line/client/output.hpp"
#include "protocol/process/options.hpp"

namespace headstock::client {

namespace {

namespace fs = std::filesystem;

std::string backup_table(const json& list) {
  std::vector<Line> rows;
  for (const auto& row : list)
    rows.push_back({cell(row.at("id")), local_time(row.at("at")), cell(row.at("kind")), cell(row.at("machine")),
                    std::to_string((row.at("bytes").get<std::int64_t>() + 1023) / 1024) + " KiB", cell(row.at("by")), cell(row.at("file"))});
  return table({say("id", "编号"), say("made", "时间"), say("kind", "种类"), say("machine", "机床"), say("size", "大小"),
                say("by", "用户"), say("file", "文件")},
               rows);
}

void bring_here(Connection& server, const json& row, const fs::path& target) {
  const fs::path part = target.string() + ".part";
  {
    std::ofstream out(part, std::ios::binary);
    fs::permissions(part, fs::perms::owner_read | fs::perms::owner_write);
    server.download("/backups/" + std::to_string(row.at("id").get<std::int64_t>()) + "/file",
                    [&](const char* bytes, std::size_t count) { out.write(bytes, static_cast<std::streamsize>(count)); });
    out.flush();
    if (!out) throw Failure(usage, say("cannot write ", "无法写入 ") + part.string());
  }
  fs::rename(part, target);
}

struct AuditOptions {
  fs::path seen;
};

/// What was seen the last time is kept in a file of the person's own: then a cut-off end is found as well.
void verify_audit(Context& context, const AuditOptions& given) {
  auto server = context.connect();
  std::string path = "/audit/verification";
  if (!given.seen.empty()) {
    std::ifstream in(given.seen);
    std::int64_t last = 0;
    std::string hash;
    if (in >> last >> hash) path += "?last=" + std::to_string(last) + "&hash=" + encoded(hash);
  }
  const auto found = server.get(path);
  if (!found.value("whole", false)) {
    context.status = refused;
    show(context, found, say("the audit trail was tampered with: row ", "审计记录被篡改：第 ") + cell(found.at("broken")) + " " +
                             found.value("what", std::string()));
    return;
  }
  if (!given.seen.empty()) {
    std::ofstream out(given.seen);
    out << found.at("rows").get<std::int64_t>() << " " << found.at("hash").get<std::string>() << "\n";
    if (!out) throw Failure(usage, say("cannot write ", "无法写入 ") + given.seen.string());
  }
  show(context, found, say("the audit trail is whole: ", "审计记录完整：") + cell(found.at("rows")) + say(" rows, newest ", " 行，最新 ") +
                           found.value("hash", std::string()));
}

void add_audit(options::Command app, Context& context) {
  auto audit = app.add_command("audit", "Who changed what (administrator)");
  audit.requires_command();
  const auto options = std::make_shared<AuditOptions>();
  auto check = audit.add_command("verify", "Is the chain of the audit trail whole? Exit status 2 when it is not");
  check.option("--seen", options->seen, "File that remembers the newest row between calls, so that a cut-off end is found");
  check.callback([&context, options] { guarded(context, [&] { verify_audit(context, *options); }); });
  const auto limit = std::make_shared<int>(100);
  auto list = audit.add_command("list", "The newest rows");
  list.option("--limit", *limit, "How many").between(1, 1000).shows_default();
  list.callback([&context, limit] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto answer = server.get("/audit?limit=" + std::to_string(*limit));
      std::vector<Line> rows;
      for (const auto& row : answer.at("items"))
        rows.push_back({cell(row.at("id")), local_time(row.at("at")), cell(row.at("user")), cell(row.at("action")), cell(row.at("subject")),
                        row.at("detail").is_string() ? row.at("detail").get<std::string>() : row.at("detail").dump()});
      show(context, answer.at("items"), table({say("id", "编号"), say("at", "时间"), say("user", "用户"), say("action", "操作"), say("subject", "对象"), say("detail", "详情")}, rows));
    });
  });
}

struct BackupOptions {
  std::string machine;
  fs::path output, file;
  std::int64_t id = 0;
};

std::string restored_text(const json& answer) {
  std::vector<Line> rows;
  for (const auto& program : answer.at("programs"))
    rows.push_back({cell(program.at("name")), cell(program.at("state")), program.value("reason", std::string())});
  std::string text = table({say("program", "程序"), say("state", "状态"), say("reason", "原因")}, rows);
  const auto& values = answer.at("values");
  text += say("values: ", "数据：") + values.value("state", std::string()) + " (" + cell(values.at("in_backup")) + ")\n";
  text += say("machine file: ", "机床文件：") + answer.value("machine_file", std::string()) + "\n";
  for (const auto& name : answer.at("not_here")) text += say("not in the backup: ", "备份中没有：") + cell(name) + "\n";
  return text;
}

void add_backup(options::Command app, Context& context) {
  auto backup = app.add_command("backup", "Backups of the server and of machines");
  backup.requires_command();
  const auto options = std::make_shared<BackupOptions>();

  auto make = backup.add_command("make", "Everything of one machine, or of the whole server while it runs");
  make.option("--machine", options->machine, "Only this machine (name or number)");
  make.option("-o,--output", options->output, "Also bring the file here");
  make.callback([&context, options] {
    guarded(context, [&] {
      auto server = context.connect();
      const std::string path = options->machine.empty()
                                   ? "/backups"
                                   : "/machines/" + std::to_string(find_machine(server, options->machine).at("id").get<std::int64_t>()) + "/backup";
      const auto row = server.send("POST", path);
      if (!options->output.empty())
        bring_here(server, row, fs::is_directory(options->output) ? options->output / row.at("file").get<std::string>() : options->output);
      show(context, row, backup_table(json::array({row})));
    });
  });
  backup.add_command("list", "Backups that the server keeps").callback([&context] {
    guarded(context, [&] {
      const auto list = context.connect().get("/backups").at("items");
      show(context, list, backup_table(list));
    });
  });
  auto get = backup.add_command("get", "Bring a backup's file here");
  get.option("id", options->id, "Its number").required();
  get.option("-o,--output", options->output, "File").required();
  get.callback([&context, options] {
    guarded(context, [&] {
      auto server = context.connect();
      bring_here(server, {{"id", options->id}}, options->output);
      show(context, {{"file", options->output.string()}}, options->output.string());
    });
  });
  auto verify = backup.add_command("verify", "Read it all and compare every checksum");
  verify.option("id", options->id, "Its number").required();
  verify.callback([&context, options] {
    guarded(context, [&] {
      const auto answer = context.connect().get("/backups/" + std::to_string(options->id) + "/verification");
      show(context, answer, say("whole, entries: ", "完整，条目数：") + cell(answer.at("entries")));
    });
  });
  auto bring = backup.add_command("bring", "Give the server a backup file to keep");
  bring.option("file", options->file, "The file").required().existing_file();
  bring.callback([&context, options] {
    guarded(context, [&] {
      const auto row = context.connect().upload("/backups/file", options->file, [](std::uint64_t, std::uint64_t) {});
      show(context, row, backup_table(json::array({row})));
    });
  });
  auto restore = backup.add_command("restore", "Bring a machine's backup back to it or to a replacement");
  restore.option("id", options->id, "Number of the backup").required();
  restore.option("--machine", options->machine, "The machine (name or number)").required();
  restore.callback([&context, options] {
    guarded(context, [&] {
      auto server = context.connect();
      const auto machine = find_machine(server, options->machine).at("id").get<std::int64_t>();
      const auto answer = server.send("POST", "/machines/" + std::to_string(machine) + "/restore", {{"backup", options->id}});
      show(context, answer, restored_text(answer));
    });
  });
  backup.footer("A whole server is restored without one running: headstock-server --data EMPTY-FOLDER --restore FILE");
}

}  // namespace

void add_keeping_commands(options::Command app, Context& context) {
  add_audit(app, context);
  add_backup(app, context);
}

}  // namespace headstock::client
