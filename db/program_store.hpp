// Folders, programs, revisions, releases and check results. Plain rows; the rules are in server/library.
// Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "db/page.hpp"

namespace headstock::db {

/// What is known of a text without understanding it.
struct BlobRow {
  std::string sha256;
  std::int64_t bytes = 0, lines = 0, longest_line = 0;
  std::string encoding;   ///< ascii, utf-8, gbk, other
  std::string line_ends;  ///< lf, crlf, cr, mixed, none
  std::int64_t nul_bytes = 0;
  bool has_percent = false;  ///< starts with a % line (after leading blank lines)
};

struct ReleaseRow {
  std::int64_t id = 0, program = 0, revision = 0, at_ms = 0;
  std::string by, why;
  std::optional<std::int64_t> withdrawn_ms;
  std::string withdrawn_by, withdrawn_why;
};

struct RevisionRow {
  std::int64_t program = 0, number = 0;
  BlobRow blob;
  std::string by, note;
  std::string origin;  ///< upload, machine:3, …
  std::int64_t at_ms = 0;
  std::optional<ReleaseRow> released;  ///< when this is the released revision
};

struct ProgramRow {
  std::int64_t id = 0;
  std::string folder, name;  ///< folder: "/" or "/customer/part"
  std::int64_t created_ms = 0;
  std::optional<RevisionRow> newest, released;
};

struct CheckRow {
  std::int64_t id = 0, machine = 0;
  std::string sha256, config_hash, checker;
  std::int64_t offsets_version = 0;
  bool ok = false;
  std::string result_json;
  std::int64_t at_ms = 0;
};

std::vector<std::string> folders(Database& db);
/// Makes the folder and those above it. @return its id.
std::int64_t ensure_folder(Database& db, const std::string& path);
std::optional<std::int64_t> folder_id(Database& db, const std::string& path);

struct ProgramFilter {
  std::optional<std::string> folder;  ///< exactly this folder
  std::string text;                   ///< part of the name
};
Listed<ProgramRow> programs(Database& db, const ProgramFilter& filter, const Page& page);
std::optional<ProgramRow> program(Database& db, std::int64_t id);
std::optional<ProgramRow> program_named(Database& db, const std::string& folder, const std::string& name);
std::int64_t insert_program(Database& db, std::int64_t folder, const std::string& name, std::int64_t at_ms);

std::optional<BlobRow> blob(Database& db, const std::string& sha256);
void insert_blob(Database& db, const BlobRow& blob, std::int64_t at_ms);

std::vector<RevisionRow> revisions(Database& db, std::int64_t program);
std::optional<RevisionRow> revision(Database& db, std::int64_t program, std::int64_t number);
void insert_revision(Database& db, const RevisionRow& revision);
/// The revision a machine's content belongs to: released ones first, then the newest.
std::optional<RevisionRow> revision_of_content(Database& db, const std::string& sha256);

std::optional<ReleaseRow> current_release(Database& db, std::int64_t program);
std::vector<ReleaseRow> releases(Database& db, std::int64_t program);
std::int64_t insert_release(Database& db, const ReleaseRow& release);
void withdraw_release(Database& db, std::int64_t id, const std::string& by, const std::string& why,
                      std::int64_t at_ms);

void put_check(Database& db, const CheckRow& check);
/// The result for exactly this machine as it is configured and set now.
std::optional<CheckRow> find_check(Database& db, const std::string& sha256, std::int64_t machine,
                                   const std::string& config_hash, std::int64_t offsets_version,
                                   const std::string& checker);
/// The latest result of each machine for this content.
std::vector<CheckRow> checks(Database& db, const std::string& sha256);

}  // namespace headstock::db
