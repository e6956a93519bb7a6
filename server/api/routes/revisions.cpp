#include <charconv>

#include "db/program_store.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/api/jobs.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/fleet/fleet.hpp"
#include "server/library/checks.hpp"
#include "server/library/difference.hpp"
#include "server/library/lines.hpp"
#include "server/library/programs.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;
using access::Action;

/// Two texts are compared in memory; what is larger is not compared.
constexpr std::int64_t comparable_bytes = 64 << 20;

awaitable<db::RevisionRow> require(Services& s, const Call& call) {
  const auto program = call.id("id"), number = call.id("n");
  co_return co_await s.store.run(
      [=](db::Database& db) { return library::require_revision(db, program, number); });
}

/// A part of a stored text, read by a worker 256 KiB at a time.
class BlobStream final : public ReplyStream {
 public:
  BlobStream(Services& s, std::shared_ptr<db::Blobs::Reader> reader, std::uint64_t from, std::uint64_t bytes)
      : s_(s), reader_(std::move(reader)), at_(from), size_(bytes) {}
  std::uint64_t size() const override { return size_; }
  awaitable<std::size_t> read(char* into, std::size_t at_most) override {
    const auto got = co_await s_.workers.run([&] { return reader_->read(at_, into, at_most); });
    at_ += got;
    co_return got;
  }

 private:
  Services& s_;
  std::shared_ptr<db::Blobs::Reader> reader_;
  std::uint64_t at_, size_;
};

struct ByteRange {
  std::uint64_t first = 0, last = 0;
};

/// `bytes=a-b`, `bytes=a-`, `bytes=-n`. @return nothing for what is to be ignored (other units, several ranges).
std::optional<ByteRange> range_of(const std::string& header, std::uint64_t size) {
  std::string_view text = header;
  if (!text.starts_with("bytes=") || text.find(',') != std::string_view::npos) return std::nullopt;
  text.remove_prefix(6);
  const auto dash = text.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const auto number = [](std::string_view digits, std::uint64_t& out) {
    const auto [at, error] = std::from_chars(digits.data(), digits.data() + digits.size(), out);
    return error == std::errc() && at == digits.data() + digits.size();
  };
  ByteRange range;
  range.last = size == 0 ? 0 : size - 1;
  const auto first = text.substr(0, dash), last = text.substr(dash + 1);
  if (first.empty()) {
    std::uint64_t tail = 0;
    if (!number(last, tail)) return std::nullopt;
    range.first = tail >= size ? 0 : size - tail;
    if (tail == 0) throw Refused("bad_range");
    return range;
  }
  if (!number(first, range.first)) return std::nullopt;
  std::uint64_t asked = 0;
  if (!last.empty()) {
    if (!number(last, asked) || asked < range.first) return std::nullopt;
    range.last = std::min(range.last, asked);
  }
  if (range.first >= size) throw Refused("bad_range");
  return range;
}

std::string percent_encoded(const std::string& text) {
  static constexpr char digits[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte >= '0' && byte <= '9') || (byte >= 'A' && byte <= 'Z') || (byte >= 'a' && byte <= 'z') || byte == '.' ||
        byte == '-' || byte == '_') {
      out += c;
    } else {
      out += '%';
      out += digits[byte >> 4];
      out += digits[byte & 15];
    }
  }
  return out;
}

awaitable<Reply> listing(Services& s, const Call& call, const db::RevisionRow& revision) {
  const auto from = call.number("from_line", 1), count = call.number("lines", 500);
  if (from < 1) throw Refused("bad_request", "from_line");
  if (count < 1 || count > 2000) throw Refused("bad_request", "lines");
  const auto window = co_await s.workers.run(
      [&] { return s.lines.window(revision.blob.sha256, revision.blob.encoding, from, count); });
  json lines = json::array(), cut = json::array();
  for (const auto& line : window.lines) {
    lines.push_back(line.text);
    if (line.cut) cut.push_back(line.number);
  }
  co_return json_reply({{"from", from}, {"total", window.total}, {"lines", std::move(lines)}, {"cut", std::move(cut)}});
}

awaitable<Reply> content(Services& s, Call& call) {
  const auto revision = co_await require(s, call);
  if (call.request.query.contains("from_line") || call.request.query.contains("lines"))
    co_return co_await listing(s, call, revision);
  const auto program = co_await s.store.run(
      [id = revision.program](db::Database& db) { return library::require_program(db, id); });
  const auto reader = co_await s.workers.run([&] { return s.blobs.open(revision.blob.sha256); });
  Reply reply;
  reply.content_type = "application/octet-stream";
  reply.headers.emplace_back("ETag", "\"" + revision.blob.sha256 + "\"");
  reply.headers.emplace_back("Accept-Ranges", "bytes");
  reply.headers.emplace_back("Content-Disposition", "attachment; filename*=UTF-8''" + percent_encoded(program.name));
  std::uint64_t first = 0, bytes = reader->size();
  if (const auto range = range_of(call.request.headers.range, reader->size())) {
    first = range->first;
    bytes = range->last - range->first + 1;
    reply.status = 206;
    reply.headers.emplace_back("Content-Range", "bytes " + std::to_string(range->first) + "-" +
                                                    std::to_string(range->last) + "/" +
                                                    std::to_string(reader->size()));
  }
  reply.stream = std::make_unique<BlobStream>(s, reader, first, bytes);
  co_return reply;
}

std::string read_whole(const db::Blobs& blobs, const std::string& sha256) {
  const auto reader = blobs.open(sha256);
  std::string text(reader->size(), '\0');
  std::size_t at = 0;
  while (at < text.size()) {
    const auto got = reader->read(at, text.data() + at, text.size() - at);
    if (got == 0) break;
    at += got;
  }
  text.resize(at);
  return text;
}

awaitable<json> difference(Services& s, db::RevisionRow left, db::RevisionRow right, std::int64_t context) {
  const auto compare = [&s, left, right, context] {
    library::DiffOptions options;
    options.context = context;
    return to_json(library::compare(read_whole(s.blobs, left.blob.sha256), left.blob.encoding,
                                    read_whole(s.blobs, right.blob.sha256), right.blob.encoding, options));
  };
  co_return co_await s.workers.run(compare);
}

awaitable<json> check(Services& s, access::Actor actor, std::int64_t program, std::int64_t revision,
                      std::int64_t machine) {
  const auto result = co_await s.checks.check(actor, program, revision, machine);
  co_return library::to_json(result);
}

awaitable<json> backplot(Services& s, std::int64_t program, std::int64_t revision, std::int64_t machine,
                         std::string profile, std::int64_t points) {
  const auto plot = co_await s.checks.backplot(program, revision, machine, profile, points);
  co_return to_json(plot);
}

std::vector<Route> reading(Services& s) {
  std::vector<Route> routes;
  routes.push_back(
      {.method = Method::get, .pattern = "/programs/{id}/revisions/{n}/content", .role = Role::viewer,
       .summary = "The exact bytes, or with from_line a window of the text as JSON", .response = "bytes",
       .query = {{"from_line", "integer", "first line, from 1"}, {"lines", "integer", "1…2000, 500 unless told"}},
       .errors = {"bad_range", "damaged_content"},
       .handler = [&s](Call& call) -> awaitable<Reply> { co_return co_await content(s, call); }});
  routes.push_back(
      {.method = Method::get, .pattern = "/programs/{id}/diff", .role = Role::viewer,
       .summary = "Two revisions side by side, each change classified", .response = "Difference",
       .query = {{"from", "integer", "revision on the left"},
                 {"to", "integer", "revision on the right"},
                 {"context", "integer", "equal lines kept around changes; all unless told"}},
       .errors = {"too_large"}, .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto id = call.id("id"), from = call.number("from", 0), to = call.number("to", 0);
         const auto context = call.number("context", -1);
         db::RevisionRow left, right;
         co_await s.store.run([&](db::Database& db) {
           left = library::require_revision(db, id, from);
           right = library::require_revision(db, id, to);
         });
         if (left.blob.bytes > comparable_bytes || right.blob.bytes > comparable_bytes)
           throw Refused("too_large", "", "64 MiB");
         co_return co_await s.jobs.run(difference(s, left, right, context), call.who.user_id);
       }});
  routes.push_back(
      {.method = Method::get, .pattern = "/programs/{id}/revisions/{n}/backplot", .role = Role::viewer,
       .summary = "The tool path as chords in work coordinates", .response = "Backplot",
       .query = {{"machine", "integer", "as this machine runs it"},
                 {"profile", "string", "or as the default machine of this controller"},
                 {"points", "integer", "at most so many, 200000 unless told"}},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto machine = call.number("machine", 0), points = call.number("points", 200'000);
         const auto profile = call.text("profile");
         if (machine == 0 && profile.empty()) throw Refused("bad_request", "machine");
         if (points < 2 || points > 1'000'000) throw Refused("bad_request", "points");
         co_return co_await s.jobs.run(backplot(s, call.id("id"), call.id("n"), machine, profile, points),
                                       call.who.user_id);
       }});
  routes.push_back({.method = Method::get, .pattern = "/programs/{id}/revisions/{n}/checks", .role = Role::viewer,
                    .summary = "The latest check on each machine", .response = "Checks",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto revision = co_await require(s, call);
                      const auto rows = co_await s.store.run([&](db::Database& db) {
                        return db::checks(db, revision.blob.sha256);
                      });
                      json items = json::array();
                      for (const auto& row : rows) {
                        json result = json::parse(row.result_json, nullptr, false);
                        if (!result.is_object()) continue;
                        // The kept form is the store's own; the answer's form is that of a check.
                        json shown = library::to_json(library::check_result_from_json(result));
                        shown["machine"] = row.machine;
                        shown["at"] = time_json(row.at_ms);
                        items.push_back(std::move(shown));
                      }
                      co_return json_reply({{"items", std::move(items)}, {"next", nullptr}});
                    }});
  return routes;
}

std::vector<Route> deciding(Services& s) {
  std::vector<Route> routes;
  routes.push_back(
      {.method = Method::post, .pattern = "/programs/{id}/revisions/{n}/check", .role = needs(Action::check_program),
       .summary = "Would this machine run it? 202 with a job when it takes longer", .takes = Takes::json,
       .request = "CheckRequest", .response = "CheckResult", .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto machine = call.body_number("machine");
         co_return co_await s.jobs.run(check(s, actor_of(call), call.id("id"), call.id("n"), machine),
                                       call.who.user_id);
       }});
  routes.push_back(
      {.method = Method::post, .pattern = "/programs/{id}/revisions/{n}/release", .role = needs(Action::release_program),
       .summary = "Make this revision the one that may be sent and run", .takes = Takes::json, .request = "Release",
       .response = "Program", .errors = {"reason_missing", "not_checked"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         const auto actor = actor_of(call);
         const auto id = call.id("id"), number = call.id("n");
         const auto why = call.body_text("why", "");
         const auto machine = call.body.contains("machine") ? call.body_number("machine") : 0;
         const auto row = co_await s.store.run([&](db::Database& db) {
           library::release(db, actor, id, number, why, db::now_ms(), machine);
           return library::require_program(db, id);
         });
         co_await s.fleet.refresh();
         announce_program(s, "released", id);
         co_return json_reply(to_json(row));
       }});
  routes.push_back({.method = Method::del, .pattern = "/programs/{id}/release",
                    .role = needs(Action::withdraw_release), .summary = "Withdraw the release", .takes = Takes::json,
                    .request = "Reason", .response = "Program", .errors = {"reason_missing", "not_released"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto id = call.id("id");
                      const auto why = call.body_text("why", "");
                      const auto row = co_await s.store.run([&](db::Database& db) {
                        library::withdraw(db, actor, id, why, db::now_ms());
                        return library::require_program(db, id);
                      });
                      co_await s.fleet.refresh();
                      announce_program(s, "withdrawn", id);
                      co_return json_reply(to_json(row));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/jobs/{id}", .role = Role::viewer,
                    .summary = "Work that was answered with 202", .response = "Job",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      co_return json_reply(s.jobs.find(call.id("id"), call.who.user_id));
                    }});
  return routes;
}

}  // namespace

std::vector<Route> revision_routes(Services& s) {
  auto routes = reading(s);
  auto more = deciding(s);
  std::move(more.begin(), more.end(), std::back_inserter(routes));
  return routes;
}

}  // namespace headstock::api
