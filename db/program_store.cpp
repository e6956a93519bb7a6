#include "db/program_store.hpp"

#include "db/filter.hpp"

namespace headstock::db {
namespace {

constexpr const char* kRevision =
    "SELECT v.program_id, v.number, v.sha256, b.bytes, b.lines, b.longest_line, b.encoding, b.line_ends, "
    "b.nul_bytes, "
    "b.has_percent, v.by_user, v.note, v.origin, v.at_ms, l.id, l.at_ms, l.by_user, l.why "
    "FROM revisions v JOIN blobs b ON b.sha256 = v.sha256 "
    "LEFT JOIN releases l ON l.program_id = v.program_id AND l.revision = v.number AND l.withdrawn_ms IS "
    "NULL ";

RevisionRow revision_of(const Row& row) {
  RevisionRow revision;
  revision.program = row.integer(0);
  revision.number = row.integer(1);
  revision.blob = {row.text(2), row.integer(3), row.integer(4), row.integer(5),
                   row.text(6), row.text(7),    row.integer(8), row.flag(9)};
  revision.by = row.text(10);
  revision.note = row.text(11);
  revision.origin = row.text(12);
  revision.at_ms = row.integer(13);
  if (!row.is_null(14)) {
    ReleaseRow release;
    release.id = row.integer(14);
    release.program = revision.program;
    release.revision = revision.number;
    release.at_ms = row.integer(15);
    release.by = row.text(16);
    release.why = row.text(17);
    revision.released = std::move(release);
  }
  return revision;
}

std::vector<RevisionRow> revisions_where(Database& db, const std::string& rest, const Values& values) {
  std::vector<RevisionRow> found;
  db.each(kRevision + rest, values, [&](const Row& row) { found.push_back(revision_of(row)); });
  return found;
}

std::optional<RevisionRow> first(std::vector<RevisionRow> rows) {
  return rows.empty() ? std::nullopt : std::optional(std::move(rows.front()));
}

constexpr const char* kProgram =
    "SELECT p.id, f.path, p.name, p.created_ms FROM programs p JOIN folders f ON f.id = p.folder_id";

ProgramRow program_of(const Row& row) {
  ProgramRow program;
  program.id = row.integer(0);
  program.folder = row.text(1);
  program.name = row.text(2);
  program.created_ms = row.integer(3);
  return program;
}

void add_revisions(Database& db, ProgramRow& program) {
  program.newest =
      first(revisions_where(db, "WHERE v.program_id = ? ORDER BY v.number DESC LIMIT 1", {program.id}));
  program.released = first(revisions_where(db, "WHERE v.program_id = ? AND l.id IS NOT NULL", {program.id}));
}

std::optional<ProgramRow> program_where(Database& db, const std::string& condition, const Values& values) {
  std::optional<ProgramRow> found;
  db.each(std::string(kProgram) + " WHERE p.removed_ms IS NULL AND " + condition, values,
          [&](const Row& row) { found = program_of(row); });
  if (found) add_revisions(db, *found);
  return found;
}

ReleaseRow release_of(const Row& row) {
  return {row.integer(0), row.integer(1),       row.integer(2), row.integer(3), row.text(4),
          row.text(5),    row.maybe_integer(6), row.text(7),    row.text(8)};
}

constexpr const char* kRelease =
    "SELECT id, program_id, revision, at_ms, by_user, why, withdrawn_ms, withdrawn_by, withdrawn_why FROM "
    "releases ";

constexpr const char* kCheck =
    "SELECT id, machine_id, sha256, config_hash, checker, offsets_version, ok, result_json, at_ms FROM "
    "checks ";

CheckRow check_of(const Row& row) {
  return {row.integer(0), row.integer(1), row.text(2), row.text(3),   row.text(4),
          row.integer(5), row.flag(6),    row.text(7), row.integer(8)};
}

}  // namespace

std::vector<std::string> folders(Database& db) {
  std::vector<std::string> found;
  db.each("SELECT path FROM folders ORDER BY path", {},
          [&](const Row& row) { found.push_back(row.text(0)); });
  if (found.empty() || found.front() != "/") found.insert(found.begin(), "/");
  return found;
}

std::int64_t ensure_folder(Database& db, const std::string& path) {
  if (const auto id = folder_id(db, path)) return *id;
  if (path != "/") {
    const auto slash = path.rfind('/');
    ensure_folder(db, slash == 0 ? "/" : path.substr(0, slash));
  }
  return *db.integer("INSERT INTO folders (path) VALUES (?) RETURNING id", {path});
}

std::optional<std::int64_t> folder_id(Database& db, const std::string& path) {
  return db.integer("SELECT id FROM folders WHERE path = ?", {path});
}

Listed<ProgramRow> programs(Database& db, const ProgramFilter& filter, const Page& page) {
  Where where;
  where.add("p.removed_ms IS NULL");
  if (filter.folder) where.add("f.path = ?", *filter.folder);
  if (!filter.text.empty()) where.add("p.name LIKE ? ESCAPE '\\'", like_part(filter.text));
  where.page("p.id", page);
  auto list = listed<ProgramRow>(db, kProgram, where, "p.id", page, program_of,
                                 [](const ProgramRow& row) { return row.id; });
  for (ProgramRow& row : list.items) add_revisions(db, row);
  return list;
}

std::optional<ProgramRow> program(Database& db, std::int64_t id) {
  return program_where(db, "p.id = ?", {id});
}

std::optional<ProgramRow> program_named(Database& db, const std::string& folder, const std::string& name) {
  return program_where(db, "f.path = ? AND p.name = ?", {folder, name});
}

std::int64_t insert_program(Database& db, std::int64_t folder, const std::string& name, std::int64_t at_ms) {
  return *db.integer("INSERT INTO programs (folder_id, name, created_ms) VALUES (?, ?, ?) RETURNING id",
                     {folder, name, at_ms});
}

std::optional<BlobRow> blob(Database& db, const std::string& sha256) {
  std::optional<BlobRow> found;
  db.each(
      "SELECT sha256, bytes, lines, longest_line, encoding, line_ends, nul_bytes, has_percent FROM blobs "
      "WHERE sha256 = ?",
      {sha256}, [&](const Row& row) {
        found = BlobRow{row.text(0), row.integer(1), row.integer(2), row.integer(3),
                        row.text(4), row.text(5),    row.integer(6), row.flag(7)};
      });
  return found;
}

void insert_blob(Database& db, const BlobRow& blob, std::int64_t at_ms) {
  db.execute(
      "INSERT INTO blobs (sha256, bytes, lines, longest_line, encoding, line_ends, nul_bytes, has_percent, "
      "created_ms) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING",
      {blob.sha256, blob.bytes, blob.lines, blob.longest_line, blob.encoding, blob.line_ends, blob.nul_bytes,
       blob.has_percent, at_ms});
}

std::vector<RevisionRow> revisions(Database& db, std::int64_t program) {
  return revisions_where(db, "WHERE v.program_id = ? ORDER BY v.number DESC", {program});
}

std::optional<RevisionRow> revision(Database& db, std::int64_t program, std::int64_t number) {
  return first(revisions_where(db, "WHERE v.program_id = ? AND v.number = ?", {program, number}));
}

void insert_revision(Database& db, const RevisionRow& revision) {
  db.execute(
      "INSERT INTO revisions (program_id, number, sha256, by_user, at_ms, note, origin) VALUES (?, ?, ?, ?, "
      "?, ?, ?)",
      {revision.program, revision.number, revision.blob.sha256, revision.by, revision.at_ms, revision.note,
       revision.origin});
}

std::optional<RevisionRow> revision_of_content(Database& db, const std::string& sha256) {
  return first(
      revisions_where(db,
                      "JOIN programs p ON p.id = v.program_id AND p.removed_ms IS NULL WHERE v.sha256 = ? "
                      "ORDER BY (l.id IS NULL), v.at_ms DESC, v.number DESC LIMIT 1",
                      {sha256}));
}

std::optional<ReleaseRow> current_release(Database& db, std::int64_t program) {
  std::optional<ReleaseRow> found;
  db.each(std::string(kRelease) + "WHERE program_id = ? AND withdrawn_ms IS NULL", {program},
          [&](const Row& row) { found = release_of(row); });
  return found;
}

std::vector<ReleaseRow> releases(Database& db, std::int64_t program) {
  std::vector<ReleaseRow> found;
  db.each(std::string(kRelease) + "WHERE program_id = ? ORDER BY id DESC", {program},
          [&](const Row& row) { found.push_back(release_of(row)); });
  return found;
}

std::int64_t insert_release(Database& db, const ReleaseRow& release) {
  return *db.integer(
      "INSERT INTO releases (program_id, revision, by_user, at_ms, why) VALUES (?, ?, ?, ?, ?) RETURNING id",
      {release.program, release.revision, release.by, release.at_ms, release.why});
}

void withdraw_release(Database& db, std::int64_t id, const std::string& by, const std::string& why,
                      std::int64_t at_ms) {
  db.execute(
      "UPDATE releases SET withdrawn_by = ?, withdrawn_why = ?, withdrawn_ms = ? WHERE id = ? AND "
      "withdrawn_ms IS NULL",
      {by, why, at_ms, id});
}

void put_check(Database& db, const CheckRow& check) {
  db.execute(
      "INSERT INTO checks (sha256, machine_id, config_hash, offsets_version, checker, ok, result_json, "
      "at_ms) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?) ON CONFLICT (sha256, machine_id, config_hash, offsets_version, "
      "checker) "
      "DO UPDATE SET ok = excluded.ok, result_json = excluded.result_json, at_ms = excluded.at_ms",
      {check.sha256, check.machine, check.config_hash, check.offsets_version, check.checker, check.ok,
       check.result_json, check.at_ms});
}

std::optional<CheckRow> find_check(Database& db, const std::string& sha256, std::int64_t machine,
                                   const std::string& config_hash, std::int64_t offsets_version,
                                   const std::string& checker) {
  std::optional<CheckRow> found;
  db.each(
      std::string(kCheck) +
          "WHERE sha256 = ? AND machine_id = ? AND config_hash = ? AND offsets_version = ? AND checker = ?",
      {sha256, machine, config_hash, offsets_version, checker},
      [&](const Row& row) { found = check_of(row); });
  return found;
}

std::vector<CheckRow> checks(Database& db, const std::string& sha256) {
  std::vector<CheckRow> found;
  db.each(std::string(kCheck) +
              "c WHERE sha256 = ? AND at_ms = (SELECT MAX(at_ms) FROM checks x WHERE x.sha256 = c.sha256 "
              "AND x.machine_id = c.machine_id) ORDER BY machine_id",
          {sha256}, [&](const Row& row) { found.push_back(check_of(row)); });
  return found;
}

}  // namespace headstock::db
