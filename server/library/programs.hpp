// The program library: what is uploaded, where it is kept, what is released. Functions that take a Database
// run on the store thread, each in its own transaction with its audit row.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/blobs.hpp"
#include "db/program_store.hpp"
#include "server/access/role.hpp"
#include "server/library/text_facts.hpp"

namespace headstock::library {

using access::Actor;

struct UploadLimits {
  std::uint64_t max_bytes = 2ull << 30;
};

/// A text on its way in: begin, append, finish. Dropped before finish() it leaves nothing. Any thread, one at
/// a time (a worker, because it writes files).
class Upload {
 public:
  explicit Upload(const db::Blobs& blobs, UploadLimits limits = {})
      : writer_(blobs.begin()), limits_(limits) {}
  /// Throws Refusal{too_large}, db::Error{disk_full}.
  void append(std::string_view bytes);
  /// Syncs the file and puts it in place. Throws Refusal{empty_program}. @return what add_revision() needs.
  db::BlobRow finish();

 private:
  db::Blobs::Writer writer_;
  TextFacts facts_;
  UploadLimits limits_;
};

struct Place {
  std::string folder = "/", name;
};  ///< folder "/" or "/a/b"; name as the file is called
struct Added {
  db::ProgramRow program;
  db::RevisionRow revision;
  bool created = false;  ///< false: this content is already the newest revision; nothing was written
  std::optional<db::RevisionRow>
      duplicate_of;  ///< the same content under another name or as an older revision
};

// ---- store thread
/// A new program, or a new revision of the one with that name; the same content as its newest revision is the
/// same revision. Refusals: forbidden, bad_name, bad_folder.
Added add_revision(db::Database& db, const Actor& actor, const Place& place, const db::BlobRow& blob,
                   const std::string& note, const std::string& origin, std::int64_t now_ms);
/// Refusals: forbidden, not_found, name_taken, bad_name, bad_folder.
db::ProgramRow move_program(db::Database& db, const Actor& actor, std::int64_t program, const Place& to,
                            std::int64_t now_ms);
/// Takes it out of the library; revisions, runs and transfers keep referring to it. Refusals: forbidden,
/// not_found, released (withdraw first).
void remove_program(db::Database& db, const Actor& actor, std::int64_t program, std::int64_t now_ms);
void create_folder(db::Database& db, const Actor& actor, const std::string& path, std::int64_t now_ms);
/// Refusals: forbidden, not_found, not_empty.
void remove_folder(db::Database& db, const Actor& actor, const std::string& path, std::int64_t now_ms);
/// Refusals: not_found.
db::ProgramRow require_program(db::Database& db, std::int64_t program);
db::RevisionRow require_revision(db::Database& db, std::int64_t program, std::int64_t revision);

/// Makes the revision the one that may be sent and run; an earlier release is withdrawn with it. Refusals:
/// forbidden, not_found, reason_missing, not_checked (no passed check for any machine; or for this one when
/// given).
db::ReleaseRow release(db::Database& db, const Actor& actor, std::int64_t program, std::int64_t revision,
                       const std::string& why, std::int64_t now_ms, std::int64_t machine = 0);
/// Refusals: forbidden, not_found, not_released, reason_missing.
void withdraw(db::Database& db, const Actor& actor, std::int64_t program, const std::string& why,
              std::int64_t now_ms);

/// Throws Refusal{bad_folder}. "/a//b/" → "/a/b".
std::string clean_folder(const std::string& path);
/// Throws Refusal{bad_name}: 1…120 bytes of UTF-8 without control characters, "/", "\", not "." or "..".
void demand_good_name(const std::string& name);

}  // namespace headstock::library
