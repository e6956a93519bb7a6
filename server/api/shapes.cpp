#include "server/api/shapes.hpp"

#include <variant>

#include "db/event_store.hpp"
#include "db/machine_store.hpp"
#include "db/program_store.hpp"
#include "db/time.hpp"
#include "db/transfer_store.hpp"
#include "machine/machine.hpp"
#include "server/library/checks.hpp"

namespace headstock::api {

namespace {

json text_or_null(const std::string& text) { return text.empty() ? json(nullptr) : json(text); }
json id_or_null(std::int64_t id) { return id == 0 ? json(nullptr) : json(id); }
json number_or_null(const std::optional<double>& number) { return number ? json(*number) : json(nullptr); }

json both(const std::string& en, const std::string& zh) { return {{"en", en}, {"zh", zh.empty() ? en : zh}}; }

json axes_of(const db::MachineRow& row) {
  json axes = json::array();
  std::optional<machine::Machine> described;
  if (row.toml.empty()) {
    described = machine::default_machine(row.profile);
  } else {
    auto read = machine::parse_machine(row.toml, row.name, row.profile);
    if (auto* good = std::get_if<machine::Machine>(&read)) described = std::move(*good);
  }
  if (!described) return axes;
  for (const auto& axis : described->axes)
    axes.push_back({{"name", std::string(1, axis.name)},
                    {"min_mm", axis.min_mm},
                    {"max_mm", axis.max_mm},
                    {"rapid_mm_min", axis.rapid_mm_min},
                    {"max_feed_mm_min", axis.max_feed_mm_min},
                    {"rotary", axis.rotary},
                    {"diameter", axis.designation == machine::Designation::diameter}});
  return axes;
}

}  // namespace

json time_json(std::int64_t ms) { return db::iso_time(ms); }
json time_json(const std::optional<std::int64_t>& ms) { return ms ? json(db::iso_time(*ms)) : json(nullptr); }

json to_json(const access::User& user) {
  return {{"id", user.id},
          {"user", user.user},
          {"name", user.name},
          {"role", access::to_string(user.role)},
          {"language", user.language},
          {"disabled", user.disabled},
          {"must_change_password", user.must_change_password},
          {"last_sign_in", time_json(user.last_sign_in_ms)}};
}

json to_json(const db::MachineRow& row, bool detailed) {
  json machine = {{"id", row.id},
                  {"name", row.name},
                  {"profile", row.profile},
                  {"parts_required", row.parts_required},
                  {"software", text_or_null(row.software)},
                  {"created", time_json(row.created_ms)},
                  {"last_seen", time_json(row.last_seen_ms)}};
  if (detailed) {
    machine["toml"] = row.toml;
    machine["axes"] = axes_of(row);
  }
  return machine;
}

json to_json(const db::ResidentRow& row) {
  return {{"name", row.name},
          {"sha256", text_or_null(row.sha256)},
          {"bytes", row.bytes},
          {"since", time_json(row.since_ms)},
          {"selected", row.selected},
          {"reported", time_json(row.reported_ms)},
          {"program_id", id_or_null(row.program_id)},
          {"revision", id_or_null(row.revision)},
          {"stale", row.program_id == 0 ? json(nullptr) : json(row.stale)}};
}

json to_json(const db::OffsetRow& row) {
  return {{"what", row.what}, {"value", row.value}, {"at", time_json(row.at_ms)}};
}

json to_json(const db::RevisionRow& row) {
  json revision = {{"program", row.program},
                   {"number", row.number},
                   {"sha256", row.blob.sha256},
                   {"bytes", row.blob.bytes},
                   {"lines", row.blob.lines},
                   {"longest_line", row.blob.longest_line},
                   {"encoding", text_or_null(row.blob.encoding)},
                   {"line_ends", text_or_null(row.blob.line_ends)},
                   {"nul_bytes", row.blob.nul_bytes},
                   {"has_percent", row.blob.has_percent},
                   {"by", row.by},
                   {"at", time_json(row.at_ms)},
                   {"note", row.note},
                   {"origin", row.origin},
                   {"released", nullptr}};
  if (row.released)
    revision["released"] = {
        {"by", row.released->by}, {"at", time_json(row.released->at_ms)}, {"why", row.released->why}};
  return revision;
}

json to_json(const db::ProgramRow& row) {
  return {{"id", row.id},
          {"folder", row.folder},
          {"name", row.name},
          {"created", time_json(row.created_ms)},
          {"newest", row.newest ? to_json(*row.newest) : json(nullptr)},
          {"released", row.released ? to_json(*row.released) : json(nullptr)}};
}

json to_json(const db::TransferRow& row) {
  json rate = nullptr;
  if (row.started_ms && row.bytes > 0) {
    const auto until = row.ended_ms.value_or(db::now_ms());
    if (until > *row.started_ms)
      rate = static_cast<double>(row.bytes) * 1000.0 / static_cast<double>(until - *row.started_ms);
  }
  return {{"id", row.id},
          {"distribution", id_or_null(row.distribution)},
          {"machine", row.machine},
          {"program", id_or_null(row.program)},
          {"revision", id_or_null(row.revision)},
          {"name", row.name},
          {"sha256", text_or_null(row.sha256)},
          {"kind", row.kind},
          {"state", row.state},
          {"bytes", row.bytes},
          {"total", row.total},
          {"rate", rate},
          // Done is said only when the machine's own count and hash of what it took are the revision's; a drip-feed has
          // then been read to its end by the interpreter.
          {"drained", row.kind == "drip" ? json(row.state == "done") : json(nullptr)},
          {"reason", text_or_null(row.reason)},
          {"by", row.by},
          {"created", time_json(row.created_ms)},
          {"started", time_json(row.started_ms)},
          {"ended", time_json(row.ended_ms)}};
}

json to_json(const db::DistributionRow& row) {
  json transfers = json::array();
  for (const auto& transfer : row.transfers) transfers.push_back(to_json(transfer));
  return {{"id", row.id},   {"program", row.program},         {"revision", row.revision},
          {"by", row.by},   {"at", time_json(row.at_ms)},     {"transfers", std::move(transfers)}};
}

json to_json(const db::AlarmRow& row) {
  return {{"id", row.id},
          {"machine", row.machine},
          {"alarm", row.alarm},
          {"code", row.code},
          {"text", both(row.text_en, row.text_zh)},
          {"line", id_or_null(row.line)},
          {"column", id_or_null(row.column)},
          {"program", text_or_null(row.program)},
          {"block", text_or_null(row.block)},
          {"raised", time_json(row.raised_ms)},
          {"cleared", time_json(row.cleared_ms)}};
}

json to_json(const db::PartRow& row) {
  return {{"id", row.id},
          {"machine", row.machine},
          {"at", time_json(row.at_ms)},
          {"program", text_or_null(row.program)},
          {"sha256", text_or_null(row.sha256)},
          {"count", row.machine_count},
          {"total", row.machine_total},
          {"cycle_s", row.cycle_s}};
}

json to_json(const db::RunRow& row) {
  return {{"id", row.id},
          {"machine", row.machine},
          {"run", row.run},
          {"program", text_or_null(row.program)},
          {"sha256", text_or_null(row.sha256)},
          {"started", time_json(row.started_ms)},
          {"ended", time_json(row.ended_ms)},
          {"outcome", text_or_null(row.outcome)},
          {"run_s", number_or_null(row.run_s)},
          {"cutting_s", number_or_null(row.cutting_s)},
          {"parts", row.total_start && row.total_end ? json(*row.total_end - *row.total_start) : json(nullptr)},
          {"holds", row.holds ? json(*row.holds) : json(nullptr)},
          {"alarms", row.alarms ? json(*row.alarms) : json(nullptr)},
          {"overrides", row.overrides_json.empty() ? json(nullptr) : json::parse(row.overrides_json, nullptr, false)},
          {"by", text_or_null(row.by)}};
}

json to_json(const db::StateRow& row) {
  return {{"id", row.id},
          {"machine", row.machine},
          {"state", row.state},
          {"mode", text_or_null(row.mode)},
          {"source", row.source},
          {"from", time_json(row.from_ms)},
          {"to", time_json(row.to_ms)}};
}

json to_json(const db::AuditRow& row) {
  json detail = json::parse(row.detail, nullptr, false);
  if (detail.is_discarded()) detail = row.detail;
  return {{"id", row.id},         {"at", time_json(row.at_ms)}, {"user", row.user},    {"address", row.address},
          {"action", row.action}, {"subject", row.subject},     {"detail", detail},    {"hash", row.hash}};
}

json to_json(const library::Difference& difference) {
  json rows = json::array();
  for (const auto& row : difference.rows) {
    json line = {{"kind", library::to_string(row.kind)},
                 {"left", nullptr},
                 {"right", nullptr},
                 {"left_line", id_or_null(row.left_line)},
                 {"right_line", id_or_null(row.right_line)},
                 {"class", nullptr}};
    if (row.left_line != 0) line["left"] = row.left;
    if (row.right_line != 0) line["right"] = row.right;
    if (row.change != library::ChangeClass::none) line["class"] = library::to_string(row.change);
    if (row.kind == library::RowKind::skipped) line["skipped"] = row.skipped;
    rows.push_back(std::move(line));
  }
  json classes = json::array();
  for (const auto change : difference.classes) classes.push_back(library::to_string(change));
  return {{"rows", std::move(rows)},          {"classes", std::move(classes)}, {"changed", difference.changed},
          {"added", difference.added},        {"removed", difference.removed}, {"truncated", difference.truncated},
          {"coarse", difference.coarse}};
}

json to_json(const library::Backplot& backplot) {
  json moves = json::array();
  for (const auto& move : backplot.moves)
    moves.push_back({{"k", std::string(1, move.kind)}, {"l", move.line}, {"p", move.points}});
  return {{"axes", backplot.axes}, {"moves", std::move(moves)}, {"truncated", backplot.truncated}};
}

}  // namespace headstock::api
