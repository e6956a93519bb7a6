#include "server/dnc/received.hpp"

#include <algorithm>

#include "db/plan_store.hpp"
#include "db/refusal.hpp"
#include "protocol/tape/decoder.hpp"
#include "protocol/tape/machine_data.hpp"
#include "protocol/tape/punch.hpp"
#include "server/access/audit.hpp"
#include "server/dnc/punched_values.hpp"
#include "server/library/programs.hpp"

namespace headstock::dnc {
namespace {

/// Larger texts are compared by their content only.
constexpr std::int64_t kMostCompared = 8 << 20;

std::string names_of(const std::vector<library::ChangeClass>& classes) {
  std::string names;
  for (const auto change : classes) {
    if (!names.empty()) names += ',';
    names += library::to_string(change);
  }
  return names;
}

db::ReceivedRow decide(db::Database& db, const access::Actor& actor, std::int64_t id, const char* state,
                       const std::string& why, std::int64_t now_ms) {
  auto row = db::received(db, id);
  if (!row) throw db::Refusal("not_found", "received");
  if (row->decided_ms) throw db::Refusal("already_decided");
  row->state = state;
  row->decided_by = actor.user;
  row->decided_why = why;
  row->decided_ms = now_ms;
  db::update_received(db, *row);
  access::record(db, actor, std::string("received.").append(state), access::subject("received", id),
                 {{"name", row->name}, {"sha256", row->sha256}, {"why", why}});
  return *row;
}

/// The set is kept as it came; what the machine's pages know of is handed to them.
fleet::PunchedOutcome keep_data(db::Database& db, const db::Blobs& blobs, const db::ReceivedRow& row,
                                const access::Actor& actor, const Decision& decision, std::int64_t now_ms) {
  const auto text = blobs.map(row.sha256);
  db::PunchedDataRow data;
  data.received = row.id;
  data.port = row.port;
  data.machine = row.machine;
  data.kind = row.kind;
  data.name = row.name;
  data.sha256 = row.sha256;
  data.entries = static_cast<std::int64_t>(tape::machine_data(text->view()).size());
  data.by = actor.user;
  data.punched_ms = row.at_ms;
  data.accepted_ms = now_ms;
  db::insert_punched_data(db, data);
  if (row.machine == 0) return {};
  fleet::PunchedSet set;
  set.machine = row.machine;
  set.punch = row.id;
  set.at_ms = row.at_ms;
  set.why = decision.why;
  set.write = decision.write;
  auto read = punched_values(fleet::machine_pages(db, row.machine), text->view());
  set.values = std::move(read.values);
  auto outcome = fleet::take_punched(db, actor, set, now_ms);
  outcome.without_place += read.not_read;
  return outcome;
}

}  // namespace

Punch take_apart(const std::string& bytes, bool closed, const PortSettings& settings, const db::PortRow& port,
                 const db::Blobs& blobs) {
  Punch punch;
  tape::Findings findings;
  punch.text = tape::decoded(bytes, serial::read_format(settings.link), &findings);
  if (!findings.none()) {
    punch.reason = "punch_parity";
    punch.where = tape::describe(findings.kept().front());
    return punch;
  }
  tape::PunchSplitter splitter;
  splitter.put(punch.text);
  splitter.finish();
  if (splitter.too_many()) punch.reason = "too_many_programs";
  if (splitter.pieces().empty()) punch.reason = "punch_empty";
  if (!punch.reason.empty()) return punch;
  const auto rule = port.name_rule == "comment" ? tape::NameRule::comment : tape::NameRule::number;
  for (const tape::PunchedPiece& piece : splitter.pieces()) {
    Punch::Piece made;
    const std::string fallback =
        piece.kind == tape::PunchKind::program ? "received" : std::string(tape::name_of(piece.kind));
    made.row.kind = tape::name_of(piece.kind);
    made.row.name = tape::punched_name(piece, rule, fallback);
    made.row.comment = library::to_utf8(piece.comment, "");
    made.row.closed = closed || splitter.closed();
    library::Upload upload(blobs);
    upload.append("%\n");
    upload.append(std::string_view(punch.text).substr(piece.begin, piece.end - piece.begin));
    if (punch.text[piece.end - 1] != '\n') upload.append("\n");
    upload.append("%\n");
    made.blob = upload.finish();
    made.row.sha256 = made.blob.sha256;
    punch.pieces.push_back(std::move(made));
  }
  return punch;
}

std::vector<std::int64_t> keep(db::Database& db, const db::Blobs& blobs, Punch punch, const db::PortRow& port,
                               std::int64_t transfer, std::int64_t now_ms) {
  std::vector<std::int64_t> ids;
  db::Transaction transaction(db);
  for (auto& [row, blob] : punch.pieces) {
    if (!db::blob(db, blob.sha256)) db::insert_blob(db, blob, now_ms);
    row.port = port.id;
    row.machine = port.machine;
    row.transfer = transfer;
    row.folder = port.folder;
    row.at_ms = now_ms;
    const auto program = row.kind == "program" ? db::program_named(db, row.folder, row.name) : std::nullopt;
    const auto against = program ? (program->released ? program->released : program->newest) : std::nullopt;
    if (against) {
      row.program = program->id;
      row.against_revision = against->number;
      if (against->blob.sha256 == row.sha256) {
        row.state = "same";
      } else if (std::max(against->blob.bytes, blob.bytes) > kMostCompared) {
        row.classes = "structure";
      } else {
        const auto left = blobs.map(against->blob.sha256), right = blobs.map(row.sha256);
        library::DiffOptions options;
        options.max_rows = 1;
        const auto difference =
            library::compare(left->view(), against->blob.encoding, right->view(), blob.encoding, options);
        row.classes = names_of(difference.classes);
        // Line ends and the % lines are the line's, not the program's.
        if (difference.classes.empty()) row.state = "same";
      }
    }
    if (row.state == "same") {
      row.decided_by = "server";
      row.decided_ms = now_ms;
    }
    row.id = db::insert_received(db, row);
    if (row.state == "same") db::update_received(db, row);
    ids.push_back(row.id);
  }
  transaction.commit();
  return ids;
}

Acceptance accept(db::Database& db, const db::Blobs& blobs, const access::Actor& actor, std::int64_t id,
                  const Decision& decision, std::int64_t now_ms) {
  access::demand(actor, access::Action::upload_program);
  db::Transaction transaction(db);
  Acceptance made{decide(db, actor, id, "accepted", decision.why, now_ms), {}};
  db::ReceivedRow& row = made.row;
  if (row.kind == "program") {
    const auto blob = db::blob(db, row.sha256);
    if (!blob) throw db::Refusal("damaged_content", row.sha256);
    const std::string origin = std::string(row.machine != 0 ? "machine:" : "port:")
                                   .append(std::to_string(row.machine != 0 ? row.machine : row.port));
    const auto added =
        library::add_revision(db, actor, {row.folder, row.name}, *blob,
                              decision.why.empty() ? "from machine" : decision.why, origin, now_ms);
    row.program = added.program.id;
  } else {
    made.values = keep_data(db, blobs, row, actor, decision, now_ms);
  }
  transaction.commit();
  return made;
}

db::ReceivedRow reject(db::Database& db, const access::Actor& actor, std::int64_t id, const std::string& why,
                       std::int64_t now_ms) {
  access::demand(actor, access::Action::upload_program);
  db::Transaction transaction(db);
  auto row = decide(db, actor, id, "rejected", why, now_ms);
  transaction.commit();
  return row;
}

}  // namespace headstock::dnc
