#include "server/library/programs.hpp"

#include <algorithm>

#include "db/refusal.hpp"
#include "db/time.hpp"
#include "server/access/audit.hpp"

namespace headstock::library {
namespace {

using access::Action;
using access::demand;
using access::record;

constexpr std::size_t kDeepestFolder = 16;

std::string full_name(const db::ProgramRow& program) {
  return program.folder == "/" ? "/" + program.name : program.folder + "/" + program.name;
}

void demand_reason(const std::string& why) {
  if (std::ranges::all_of(why, [](unsigned char c) { return c <= ' '; })) throw db::Refusal("reason_missing");
}

void demand_short(const std::string& text, const char* what) {
  if (text.size() > 2'000) throw db::Refusal("bad_value", what);
}

bool passed_for(const db::CheckRow& check, db::Database& db) {
  if (!check.ok) return false;
  // A check of a machine that has since got another configuration says nothing about the machine as it is.
  return db
      .integer("SELECT 1 FROM machines WHERE id = ? AND config_hash = ? AND removed_ms IS NULL",
               {check.machine, check.config_hash})
      .has_value();
}

}  // namespace

void Upload::append(std::string_view bytes) {
  if (writer_.bytes() + bytes.size() > limits_.max_bytes)
    throw db::Refusal("too_large", std::to_string(limits_.max_bytes));
  facts_.add(bytes);
  writer_.append(bytes);
}

db::BlobRow Upload::finish() {
  if (writer_.bytes() == 0) throw db::Refusal("empty_program");
  db::BlobRow facts = facts_.finish();
  facts.sha256 = writer_.finish();
  return facts;
}

std::string clean_folder(const std::string& path) {
  std::string clean;
  std::size_t depth = 0;
  std::size_t at = 0;
  while (at <= path.size()) {
    const std::size_t slash = std::min(path.find('/', at), path.size());
    const std::string part = path.substr(at, slash - at);
    at = slash + 1;
    if (part.empty()) continue;
    try {
      demand_good_name(part);
    } catch (const db::Refusal&) {
      throw db::Refusal("bad_folder", path.substr(0, 200));
    }
    clean += "/" + part;
    if (++depth > kDeepestFolder) throw db::Refusal("bad_folder", "too deep");
  }
  return clean.empty() ? "/" : clean;
}

void demand_good_name(const std::string& name) {
  const bool bad_byte = std::ranges::any_of(
      name, [](unsigned char c) { return c < 0x20 || c == 0x7F || c == '/' || c == '\\'; });
  const bool bad_text = to_utf8(name, "utf-8") != name;
  const bool bad_edge = !name.empty() && (name.front() == ' ' || name.back() == ' ');
  if (name.empty() || name.size() > 120 || name == "." || name == ".." || bad_byte || bad_text || bad_edge)
    throw db::Refusal("bad_name", to_utf8(name.substr(0, 120), "utf-8"));
}

db::ProgramRow require_program(db::Database& db, std::int64_t program) {
  auto row = db::program(db, program);
  if (!row) throw db::Refusal("not_found", access::subject("program", program));
  return *row;
}

db::RevisionRow require_revision(db::Database& db, std::int64_t program, std::int64_t revision) {
  require_program(db, program);
  auto row = db::revision(db, program, revision);
  if (!row) throw db::Refusal("not_found", access::subject("program", program) + "/" + std::to_string(revision));
  return *row;
}

Added add_revision(db::Database& db, const Actor& actor, const Place& place, const db::BlobRow& blob,
                   const std::string& note, const std::string& origin, std::int64_t now_ms) {
  demand(actor, Action::upload_program);
  demand_good_name(place.name);
  demand_short(note, "note");
  const std::string folder = clean_folder(place.folder);
  db::Transaction transaction(db);
  Added added;
  auto program = db::program_named(db, folder, place.name);
  if (program && program->newest && program->newest->blob.sha256 == blob.sha256) {
    added.revision = *program->newest;
    added.program = std::move(*program);
    return added;
  }
  added.duplicate_of = db::revision_of_content(db, blob.sha256);
  db::insert_blob(db, blob, now_ms);
  const std::int64_t id =
      program ? program->id : db::insert_program(db, db::ensure_folder(db, folder), place.name, now_ms);
  db::RevisionRow revision;
  revision.program = id;
  revision.number = program && program->newest ? program->newest->number + 1 : 1;
  revision.blob = blob;
  revision.by = actor.user;
  revision.at_ms = now_ms;
  revision.note = note;
  revision.origin = origin;
  db::insert_revision(db, revision);
  record(db, actor, "program.upload", access::subject("program", id),
         {{"name", place.name},
          {"folder", folder},
          {"revision", std::to_string(revision.number)},
          {"sha256", blob.sha256},
          {"note", note}});
  added.program = require_program(db, id);
  added.revision = *db::revision(db, id, revision.number);
  added.created = true;
  transaction.commit();
  return added;
}

db::ProgramRow move_program(db::Database& db, const Actor& actor, std::int64_t program, const Place& to,
                            std::int64_t /*now_ms*/) {
  demand(actor, Action::arrange_programs);
  demand_good_name(to.name);
  const std::string folder = clean_folder(to.folder);
  db::Transaction transaction(db);
  const db::ProgramRow before = require_program(db, program);
  const auto there = db::program_named(db, folder, to.name);
  if (there && there->id != program) throw db::Refusal("name_taken", full_name(*there));
  db.execute("UPDATE programs SET folder_id = ?, name = ? WHERE id = ?",
             {db::ensure_folder(db, folder), to.name, program});
  const db::ProgramRow after = require_program(db, program);
  record(db, actor, "program.move", access::subject("program", program),
         {{"from", full_name(before)}, {"to", full_name(after)}});
  transaction.commit();
  return after;
}

void remove_program(db::Database& db, const Actor& actor, std::int64_t program, std::int64_t now_ms) {
  demand(actor, Action::arrange_programs);
  db::Transaction transaction(db);
  const db::ProgramRow row = require_program(db, program);
  if (row.released) throw db::Refusal("released", full_name(row));
  db.execute("UPDATE programs SET removed_ms = ? WHERE id = ?", {now_ms, program});
  record(db, actor, "program.remove", access::subject("program", program), {{"name", full_name(row)}});
  transaction.commit();
}

void create_folder(db::Database& db, const Actor& actor, const std::string& path, std::int64_t /*now_ms*/) {
  demand(actor, Action::arrange_programs);
  const std::string folder = clean_folder(path);
  db::Transaction transaction(db);
  if (!db::folder_id(db, folder)) {
    db::ensure_folder(db, folder);
    record(db, actor, "folder.create", "folder:" + folder);
  }
  transaction.commit();
}

void remove_folder(db::Database& db, const Actor& actor, const std::string& path, std::int64_t /*now_ms*/) {
  demand(actor, Action::arrange_programs);
  const std::string folder = clean_folder(path);
  db::Transaction transaction(db);
  const auto id = db::folder_id(db, folder);
  if (!id || folder == "/") throw db::Refusal("not_found", folder);
  const bool has_programs =
      db.integer("SELECT 1 FROM programs WHERE folder_id = ? AND removed_ms IS NULL LIMIT 1", {*id})
          .has_value();
  const bool has_folders = db.integer("SELECT 1 FROM folders WHERE substr(path, 1, CAST(? AS INTEGER)) = ? LIMIT 1",
                                      {folder.size() + 1, folder + "/"})
                               .has_value();
  if (has_programs || has_folders) throw db::Refusal("not_empty", folder);
  // Removed programs keep their history; they go to the root so that the folder's row can go.
  db.execute("UPDATE programs SET folder_id = ? WHERE folder_id = ?", {db::ensure_folder(db, "/"), *id});
  db.execute("DELETE FROM folders WHERE id = ?", {*id});
  record(db, actor, "folder.remove", "folder:" + folder);
  transaction.commit();
}

db::ReleaseRow release(db::Database& db, const Actor& actor, std::int64_t program, std::int64_t revision,
                       const std::string& why, std::int64_t now_ms, std::int64_t machine) {
  demand(actor, Action::release_program);
  demand_reason(why);
  demand_short(why, "why");
  db::Transaction transaction(db);
  const db::RevisionRow row = require_revision(db, program, revision);
  const auto checks = db::checks(db, row.blob.sha256);
  const bool passed = std::ranges::any_of(checks, [&](const db::CheckRow& check) {
    return (machine == 0 || check.machine == machine) && passed_for(check, db);
  });
  if (!passed)
    throw db::Refusal("not_checked",
                      machine == 0 ? std::string() : std::string("machine:").append(std::to_string(machine)));
  const auto current = db::current_release(db, program);
  if (current && current->revision == revision) return *current;
  if (current) db::withdraw_release(db, current->id, actor.user, why, now_ms);
  db::ReleaseRow made;
  made.program = program;
  made.revision = revision;
  made.by = actor.user;
  made.at_ms = now_ms;
  made.why = why;
  made.id = db::insert_release(db, made);
  record(db, actor, "program.release", access::subject("program", program),
         {{"revision", std::to_string(revision)},
          {"sha256", row.blob.sha256},
          {"why", why},
          {"instead_of", current ? std::to_string(current->revision) : std::string()}});
  transaction.commit();
  return made;
}

void withdraw(db::Database& db, const Actor& actor, std::int64_t program, const std::string& why,
              std::int64_t now_ms) {
  demand(actor, Action::withdraw_release);
  demand_reason(why);
  demand_short(why, "why");
  db::Transaction transaction(db);
  require_program(db, program);
  const auto current = db::current_release(db, program);
  if (!current) throw db::Refusal("not_released", access::subject("program", program));
  db::withdraw_release(db, current->id, actor.user, why, now_ms);
  record(db, actor, "program.withdraw", access::subject("program", program),
         {{"revision", std::to_string(current->revision)}, {"why", why}});
  transaction.commit();
}

}  // namespace headstock::library
