// What ports leave behind and what is planned for them: certificates, the log for other programs, plans, the census of what lies
// in every machine, machine data that were punched.
#include "db/blobs.hpp"
#include "db/plan_store.hpp"
#include "db/port_store.hpp"
#include "db/store.hpp"
#include "protocol/tape/machine_data.hpp"
#include "server/api/routes/port_json.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/dnc/census.hpp"
#include "server/dnc/dnc.hpp"
#include "server/dnc/transfer_log.hpp"
#include "server/library/text_facts.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;
using access::Action;

/// A log of more rows than this is asked for by months.
constexpr std::size_t kLargestLog = 64u << 20;

json maybe_time(std::int64_t ms) { return ms == 0 ? json(nullptr) : time_json(ms); }

json shape(const db::PlanRow& row) {
  return {{"id", row.id}, {"port", row.port}, {"program", row.program}, {"revision", row.revision}, {"name", row.name},
          {"drip", row.drip}, {"from_line", row.from_line}, {"header", maybe_text(row.header)}, {"at", time_json(row.at_ms)},
          {"state", row.state}, {"reason", maybe_text(row.reason)}, {"transfer", maybe_id(row.transfer)}, {"by", row.by},
          {"created", time_json(row.created_ms)}, {"ended", time_json(row.ended_ms)}};
}

json shape(const dnc::CensusEntry& entry) {
  json classes = json::array();
  for (std::size_t at = 0; at < entry.classes.size();) {
    const auto end = std::min(entry.classes.find(',', at), entry.classes.size());
    classes.push_back(entry.classes.substr(at, end - at));
    at = end + 1;
  }
  return {{"machine", maybe_id(entry.machine)}, {"machine_name", maybe_text(entry.machine_name)}, {"port", maybe_id(entry.port)},
          {"port_name", maybe_text(entry.port_name)}, {"name", entry.name}, {"sha256", entry.sha256},
          {"program", maybe_id(entry.program)}, {"revision", maybe_id(entry.revision)}, {"released", maybe_id(entry.released)},
          {"proof", entry.proof}, {"state", entry.state}, {"classes", std::move(classes)}, {"since", maybe_time(entry.since_ms)},
          {"proven", maybe_time(entry.proven_ms)}};
}

json shape(const db::PunchedDataRow& row) {
  return {{"id", row.id}, {"received", row.received}, {"port", row.port}, {"machine", maybe_id(row.machine)}, {"kind", row.kind},
          {"name", row.name}, {"sha256", row.sha256}, {"entries", row.entries}, {"by", row.by},
          {"punched", time_json(row.punched_ms)}, {"accepted", time_json(row.accepted_ms)}};
}

std::vector<Route> certificates(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/port-transfers/{id}", .role = Role::viewer,
                    .summary = "A transfer's certificate: revision, hashes, characters, times, outcome", .response = "PortTransfer",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      auto row = co_await s.store.run([id](db::Database& db) { return db::port_transfer(db, id); });
                      if (!row) throw Refused("not_found", "transfer");
                      for (const auto& view : s.dnc.views())
                        if (!view.is_agent && view.transfer && view.transfer->id == id) row = *view.transfer;
                      co_return json_reply(port_transfer_json(*row));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/port-transfers/{id}/tail", .role = Role::viewer,
                    .summary = "The last characters that really went out, and the last whole line of the program among them",
                    .response = "PortTail", .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto tail = co_await s.dnc.tail(id);
                      co_return json_reply({{"text", tail.known ? json(library::to_utf8(tail.text, "")) : json(nullptr)},
                                            {"line", maybe_id(tail.line)}});
                    }});
  routes.push_back({.method = Method::get, .pattern = "/transfer-log", .role = Role::viewer,
                    .summary = "Every transfer, over ports and to agents, as comma-separated values (UTF-8)", .response = "bytes",
                    .query = with({{"port", "integer", "only this port"}, {"machine", "integer", "only this machine"}}, period),
                    .errors = {"too_large"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      dnc::LogWish wish;
                      wish.port = call.number("port", 0);
                      wish.machine = call.number("machine", 0);
                      wish.from_ms = time_of(call, "from").value_or(0);
                      wish.to_ms = time_of(call, "to").value_or(0);
                      dnc::LogPlace place;
                      Reply reply;
                      reply.body = "\xEF\xBB\xBF" + dnc::log_head();
                      // A thousand rows at a time: the store has other work as well.
                      const auto piece = [&](db::Database& db) { return dnc::append_log(db, wish, place, reply.body); };
                      while (co_await s.store.run(piece))
                        if (reply.body.size() > kLargestLog) throw Refused("too_large", "from");
                      reply.content_type = "text/csv; charset=utf-8";
                      reply.headers.emplace_back("Content-Disposition", "attachment; filename=\"transfers.csv\"");
                      co_return reply;
                    }});
  return routes;
}

std::vector<Route> plans(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::post, .pattern = "/ports/{id}/plans", .role = needs(Action::open_drip),
                    .summary = "Send at a time: it waits for the control's DC1 from then on", .takes = Takes::json,
                    .request = "NewPortPlan", .response = "PortPlan", .status = 201,
                    .errors = {"cannot_queue", "not_released", "header_missing", "in_the_past", "bad_value", "not_for_agents"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      dnc::SendWish wish;
                      wish.program = call.body_number("program");
                      wish.revision = call.body_number("revision");
                      if (call.body.contains("from_line")) wish.from_line = call.body_number("from_line");
                      wish.header = call.body_text("header", "");
                      wish.drip = call.body.value("drip", json(false)) == json(true);
                      const auto at = parse_time(call.body_text("at"));
                      if (!at) throw Refused("bad_request", "at");
                      const auto id = call.id("id");
                      const auto row = co_await s.dnc.plan(actor_of(call), id, wish, *at);
                      co_return json_reply(shape(row), 201);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/port-plans", .role = Role::viewer,
                    .summary = "What is to be sent at a time, and what became of it", .response = "PortPlans",
                    .query = with({{"port", "integer", "only this port"}, {"open", "boolean", "only those to come"}}, paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto port = call.number("port", 0);
                      const bool open = call.text("open") == "true";
                      const auto page = page_of(call);
                      const auto list = co_await s.store.run([&](db::Database& db) { return db::plans(db, port, open, page); });
                      co_return json_reply(list_json(list, [](const auto& row) { return shape(row); }));
                    }});
  routes.push_back({.method = Method::del, .pattern = "/port-plans/{id}", .role = needs(Action::cancel_transfer),
                    .summary = "Take a plan back", .response = "PortPlan", .errors = {"already_decided"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto row = co_await s.dnc.cancel_plan(actor_of(call), id);
                      co_return json_reply(shape(row));
                    }});
  return routes;
}

std::vector<Route> residents(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/census", .role = Role::viewer,
                    .summary = "What lies in every machine: which revision, since when, proven by what", .response = "Census",
                    .query = {{"machine", "integer", "only this machine"}}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.number("machine", 0);
                      const auto found = co_await s.store.run([&](db::Database& db) { return dnc::census(db, machine); });
                      json items = json::array();
                      for (const auto& entry : found) items.push_back(shape(entry));
                      co_return json_reply({{"items", std::move(items)}, {"next", nullptr}});
                    }});
  routes.push_back({.method = Method::get, .pattern = "/punched-data", .role = Role::viewer,
                    .summary = "Sets of machine data that controls have punched and somebody has accepted, newest first",
                    .response = "PunchedDataList",
                    .query = with({{"machine", "integer", "only this machine"}, {"kind", "string", "tool_offsets, work_offsets, parameters, pitch_error, macro_variables, tool_life"}}, paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto machine = call.number("machine", 0);
                      const auto kind = call.text("kind");
                      const auto page = page_of(call);
                      const auto list = co_await s.store.run(
                          [&](db::Database& db) { return db::punched_data_rows(db, machine, kind, page); });
                      co_return json_reply(list_json(list, [](const auto& row) { return shape(row); }));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/punched-data/{id}", .role = Role::viewer,
                    .summary = "One set with its values, and what changed against the set before", .response = "PunchedData",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto read = [id](db::Database& db) {
                        auto row = db::punched_data(db, id);
                        auto before = row ? db::punched_data_before(db, *row) : std::nullopt;
                        return std::pair(std::move(row), std::move(before));
                      };
                      const auto [row, before] = co_await s.store.run(read);
                      if (!row) throw Refused("not_found", "punched data");
                      const std::string now = row->sha256, then = before ? before->sha256 : "";
                      const auto compare = [&] {
                        const auto entries = tape::machine_data(s.blobs.map(now)->view());
                        auto changed = then.empty() ? std::vector<tape::DataChange>{}
                                                    : tape::changes(tape::machine_data(s.blobs.map(then)->view()), entries);
                        return std::pair(entries, std::move(changed));
                      };
                      const auto [entries, changed] = co_await s.workers.run(compare);
                      json answer = shape(*row), values = json::array(), differences = json::array();
                      for (const auto& entry : entries)
                        values.push_back({{"item", library::to_utf8(entry.item, "")}, {"value", library::to_utf8(entry.value, "")}});
                      for (const auto& one : changed)
                        differences.push_back({{"item", library::to_utf8(one.item, "")},
                                               {"before", one.before ? json(library::to_utf8(*one.before, "")) : json(nullptr)},
                                               {"after", one.after ? json(library::to_utf8(*one.after, "")) : json(nullptr)}});
                      answer["values"] = std::move(values);
                      answer["against"] = before ? json(before->id) : json(nullptr);
                      answer["changes"] = std::move(differences);
                      co_return json_reply(answer);
                    }});
  return routes;
}

}  // namespace

std::vector<Route> port_record_routes(Services& s) {
  return joined(s, {certificates, plans, residents});
}

}  // namespace headstock::api
