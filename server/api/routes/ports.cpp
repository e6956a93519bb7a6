#include <algorithm>

#include "db/blobs.hpp"
#include "db/port_store.hpp"
#include "db/program_store.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/api/routes/port_json.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/dnc/dnc.hpp"
#include "server/dnc/received.hpp"
#include "server/dnc/settings.hpp"
#include "server/fleet/fleet.hpp"
#include "server/fleet/value_requests.hpp"
#include "server/library/difference.hpp"
#include "server/library/text_facts.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;
using access::Action;

json maybe_id(std::int64_t id) { return id == 0 ? json(nullptr) : json(id); }
json maybe_text(const std::string& text) { return text.empty() ? json(nullptr) : json(text); }

/// A member that may be left out.
bool flag(const Call& call, const char* name) {
  if (!call.body.contains(name)) return false;
  if (!call.body[name].is_boolean()) throw Refused("bad_request", name);
  return call.body[name].get<bool>();
}

}  // namespace

json port_transfer_json(const db::PortTransferRow& row) {
  return {{"id", row.id}, {"port", row.port}, {"kind", row.kind}, {"state", row.state},
          {"program", maybe_id(row.program)}, {"revision", maybe_id(row.revision)}, {"name", row.name},
          {"sha256", maybe_text(row.sha256)}, {"from_line", row.from_line}, {"header", maybe_text(row.header)},
          {"bytes", row.bytes}, {"total", maybe_id(row.total)}, {"wire_sha256", maybe_text(row.wire_sha256)},
          {"reason", maybe_text(row.reason)}, {"detail", maybe_text(row.detail)},
          {"figures", json::parse(row.figures_json, nullptr, false)}, {"by", row.by},
          {"created", time_json(row.created_ms)}, {"started", time_json(row.started_ms)}, {"ended", time_json(row.ended_ms)}};
}

namespace {

json shape(const db::PortTransferRow& row) { return port_transfer_json(row); }

json shape(const serial::Signals& signals) {
  if (!signals.known) return nullptr;
  return {{"rts", signals.rts}, {"dtr", signals.dtr}, {"cts", signals.cts},
          {"dsr", signals.dsr}, {"dcd", signals.dcd}, {"ring", signals.ring}};
}

json shape(const dnc::PortView& view) {
  json queue = json::array();
  for (const auto& row : view.queue) queue.push_back(shape(row));
  const auto& row = view.row;
  return {{"id", row.id}, {"name", row.name}, {"machine", maybe_id(row.machine)}, {"address", row.address},
          {"settings", json::parse(row.settings_json)}, {"listens", row.listens}, {"folder", row.folder},
          {"name_rule", row.name_rule}, {"rules", json::parse(row.rules_json)},
          {"created", time_json(row.created_ms)}, {"changed", time_json(row.changed_ms)},
          {"state", view.now.state}, {"reason", maybe_text(view.now.reason)}, {"detail", maybe_text(view.now.text)},
          {"signals", shape(view.now.signals)},
          {"transfer", view.transfer ? shape(*view.transfer) : json(nullptr)}, {"queue", std::move(queue)},
          {"kind", view.is_agent ? "agent" : "line"},
          {"measured", {{"window", view.window}, {"stop_margin", view.stop_margin}, {"transfers", view.measured.transfers},
                        {"stops", view.measured.stops}, {"most_after_stop", view.measured.most_after_stop},
                        {"longest_stop_us", view.measured.longest_stop_us}, {"longest_hold_ms", view.measured.longest_hold_ms},
                        {"starved_ms", view.measured.starved_ms}, {"sending_ms", view.measured.sending_ms},
                        {"round_trip_us", view.measured.round_trip_us == 0 ? json(nullptr) : json(view.measured.round_trip_us)}}}};
}

json shape(const db::ReceivedRow& row) {
  json classes = json::array();
  for (std::size_t at = 0; at < row.classes.size();) {
    const auto end = std::min(row.classes.find(',', at), row.classes.size());
    classes.push_back(row.classes.substr(at, end - at));
    at = end + 1;
  }
  return {{"id", row.id}, {"port", row.port}, {"transfer", row.transfer}, {"machine", maybe_id(row.machine)},
          {"kind", row.kind}, {"name", row.name}, {"comment", row.comment}, {"sha256", row.sha256},
          {"closed", row.closed}, {"folder", row.folder}, {"program", maybe_id(row.program)},
          {"against_revision", maybe_id(row.against_revision)}, {"classes", std::move(classes)}, {"state", row.state},
          {"decided_by", maybe_text(row.decided_by)}, {"decided_why", maybe_text(row.decided_why)},
          {"decided", time_json(row.decided_ms)}, {"at", time_json(row.at_ms)}};
}

template <class Row>
json shape_list(const db::Listed<Row>& list) {
  json items = json::array();
  for (const auto& row : list.items) items.push_back(shape(row));
  return {{"items", std::move(items)}, {"next", list.next ? json(std::to_string(*list.next)) : json(nullptr)}};
}

json shape(const dnc::MonitorPiece& piece, bool iso) {
  json items = json::array();
  for (const auto& entry : piece.entries) {
    const bool bytes = entry.kind == serial::MonitorEntry::in || entry.kind == serial::MonitorEntry::out;
    items.push_back({{"sequence", entry.sequence}, {"at", time_json(entry.at_ms)}, {"kind", serial::name_of(entry.kind)},
                     {"text", bytes ? serial::readable(entry.data, iso) : entry.data},
                     {"hex", bytes ? json(serial::hexadecimal(entry.data)) : json(nullptr)}});
  }
  return {{"items", std::move(items)}, {"last", piece.last}};
}

std::vector<Route> records(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/ports", .role = Role::viewer,
                    .summary = "Serial ports with their state and what is under way", .response = "Ports",
                    .handler = [&s](Call&) -> awaitable<Reply> {
                      json items = json::array();
                      for (const auto& view : s.dnc.views()) items.push_back(shape(view));
                      co_return json_reply({{"items", std::move(items)}, {"next", nullptr}});
                    }});
  routes.push_back({.method = Method::post, .pattern = "/ports", .role = needs(Action::edit_machine),
                    .summary = "Add a port: a serial device, a TCP or RFC 2217 serial-device server",
                    .takes = Takes::json, .request = "NewPort", .response = "Port", .status = 201,
                    .errors = {"bad_name", "name_taken", "bad_value", "bad_folder"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await s.dnc.create(actor_of(call), call.body);
                      co_return json_reply(shape(s.dnc.view(row.id)), 201);
                    }});
  routes.push_back({.method = Method::get, .pattern = "/ports/{id}", .role = Role::viewer, .summary = "One port",
                    .response = "Port", .handler = [&s](Call& call) -> awaitable<Reply> {
                      co_return json_reply(shape(s.dnc.view(call.id("id"))));
                    }});
  routes.push_back({.method = Method::patch, .pattern = "/ports/{id}", .role = needs(Action::edit_machine),
                    .summary = "Change a port; nothing may be under way", .takes = Takes::json, .request = "PortChange",
                    .response = "Port", .errors = {"bad_name", "name_taken", "bad_value", "bad_folder", "port_busy"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      co_await s.dnc.change(actor_of(call), id, call.body);
                      co_return json_reply(shape(s.dnc.view(id)));
                    }});
  routes.push_back({.method = Method::del, .pattern = "/ports/{id}", .role = needs(Action::edit_machine),
                    .summary = "Remove a port; its transfers stay", .status = 204, .errors = {"port_busy"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      co_await s.dnc.remove(actor_of(call), call.id("id"));
                      co_return empty_reply();
                    }});
  routes.push_back({.method = Method::get, .pattern = "/serial-protocols", .role = Role::viewer,
                    .summary = "What the controls' manuals say about their serial ports", .response = "SerialProtocols",
                    .handler = [](Call&) -> awaitable<Reply> {
                      json items = json::array();
                      for (const auto& row : serial::protocols())
                        items.push_back({{"name", row.name}, {"text", {{"en", row.en}, {"zh", row.zh}}}, {"source", row.source},
                                         {"settings", dnc::to_json({serial::default_settings(row.name), {}})}});
                      co_return json_reply({{"items", std::move(items)}, {"next", nullptr}});
                    }});
  return routes;
}

/// {"line":120} or {"block":120} or {"sequence":2000} or {"tool":5}, the last three with "occurrence".
dnc::StartWish start_wish(const Call& call) {
  using enum dnc::StartWish::By;
  dnc::StartWish wish;
  const std::pair<const char*, dnc::StartWish::By> ways[] = {{"line", line}, {"block", block}, {"sequence", sequence}, {"tool", tool}};
  int given = 0;
  for (const auto& [name, by] : ways) {
    if (!call.body.contains(name)) continue;
    wish.by = by;
    wish.value = call.body_number(name);
    ++given;
  }
  if (given != 1) throw Refused("bad_request", "line");
  if (call.body.contains("occurrence")) wish.occurrence = call.body_number("occurrence");
  return wish;
}

std::vector<Route> sending(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::post, .pattern = "/ports/{id}/send", .role = needs(Action::open_drip),
                    .summary = "Send a released revision, whole, as drip-feed, or from a line with a confirmed header",
                    .takes = Takes::json, .request = "PortSend", .response = "PortTransfer", .status = 201,
                    .errors = {"not_released", "port_busy", "cannot_queue", "header_missing", "no_code", "numbers_are_used",
                               "no_machine", "restart_not_reached", "restart_alarm", "restart_in_compensation",
                               "restart_in_cycle", "restart_mode", "restart_variables", "not_for_agents", "not_connected",
                               "check_failed", "drip_open", "machine_refused"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      dnc::SendWish wish;
                      wish.program = call.body_number("program");
                      wish.revision = call.body_number("revision");
                      if (call.body.contains("from_line")) wish.from_line = call.body_number("from_line");
                      wish.header = call.body_text("header", "");
                      wish.drip = flag(call, "drip");
                      wish.queue = flag(call, "queue");
                      wish.armed = flag(call, "armed");
                      const auto id = call.id("id");
                      const auto row = co_await s.dnc.send(actor_of(call), id, wish);
                      co_return json_reply(shape(row), 201);
                    }});
  routes.push_back({.method = Method::post, .pattern = "/ports/{id}/restart", .role = needs(Action::open_drip),
                    .summary = "What has to be sent in front to begin at a line, block, sequence number or tool: to be read, changed and confirmed",
                    .takes = Takes::json, .request = "PortRestart", .response = "PortRestartAnswer", .errors = {"no_machine", "place_not_found"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto program = call.body_number("program"), revision = call.body_number("revision");
                      const auto id = call.id("id");
                      const auto [place, restart] = co_await s.dnc.restart(id, program, revision, start_wish(call));
                      json error = nullptr;
                      if (!restart.reason.empty()) {
                        const auto text = error_text(restart.reason);
                        error = {{"code", restart.reason}, {"message", {{"en", text.en}, {"zh", text.zh}}}, {"where", restart.where}};
                      }
                      co_return json_reply({{"header", restart.header}, {"lines", restart.lines}, {"line", place.line},
                                            {"text", library::to_utf8(place.text, "")}, {"occurrences", place.occurrences},
                                            {"error", std::move(error)}});
                    }});
  routes.push_back({.method = Method::post, .pattern = "/ports/{id}/receive", .role = needs(Action::open_drip),
                    .summary = "Wait for a punch", .response = "PortTransfer", .status = 201, .errors = {"port_busy"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto row = co_await s.dnc.receive(actor_of(call), id);
                      co_return json_reply(shape(row), 201);
                    }});
  const auto steer = [&s](const char* verb, const char* summary, Action action, void (dnc::Dnc::*act)(const access::Actor&, std::int64_t)) {
    return Route{.method = Method::post, .pattern = std::string("/ports/{id}/").append(verb), .role = needs(action),
                 .summary = summary, .response = "Port", .errors = {"nothing_under_way"},
                 .handler = [&s, act](Call& call) -> awaitable<Reply> {
                   const auto id = call.id("id");
                   (s.dnc.*act)(actor_of(call), id);
                   co_return json_reply(shape(s.dnc.view(id)));
                 }};
  };
  routes.push_back(steer("pause", "Stop sending until resumed", Action::cancel_transfer, &dnc::Dnc::pause));
  routes.push_back(steer("resume", "Go on sending", Action::open_drip, &dnc::Dnc::resume));
  routes.push_back(steer("cancel", "End what is under way", Action::cancel_transfer, &dnc::Dnc::cancel));
  routes.back().urgent = true;
  routes.push_back({.method = Method::del, .pattern = "/ports/{id}/queue/{transfer}", .role = needs(Action::cancel_transfer),
                    .summary = "Take a waiting transfer out of the queue", .status = 204,
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      s.dnc.unqueue(actor_of(call), call.id("id"), call.id("transfer"));
                      co_return empty_reply();
                    }});
  routes.push_back({.method = Method::post, .pattern = "/ports/{id}/loop-test", .role = needs(Action::edit_machine),
                    .summary = "Send a test pattern and compare what comes back of it", .response = "LoopTest",
                    .errors = {"port_busy"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto report = co_await s.dnc.loop_test(actor_of(call), id, 1'000);
                      co_return json_reply({{"ok", report.ok}, {"reason", maybe_text(report.reason)}, {"detail", maybe_text(report.text)},
                                            {"sent", report.sent}, {"received", report.received}, {"first_wrong", report.first_wrong},
                                            {"round_trip_us", report.round_trip_us}, {"characters_s", report.characters_s}});
                    }});
  routes.push_back({.method = Method::get, .pattern = "/ports/{id}/monitor", .role = Role::viewer,
                    .summary = "What went over the line: bytes both ways, signals, errors", .response = "PortMonitor",
                    .query = {{"after", "integer", "only entries behind this sequence"}, {"limit", "integer", "1…1000, 200 unless told"}},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id"), after = call.number("after", 0), limit = call.number("limit", 200);
                      if (after < 0 || limit < 1 || limit > 1000) throw Refused("bad_request", "limit");
                      const auto settings = dnc::settings_from(json::parse(s.dnc.view(id).row.settings_json));
                      const auto piece = co_await s.dnc.monitor(id, static_cast<std::uint64_t>(after), static_cast<std::size_t>(limit));
                      co_return json_reply(shape(piece, settings.link.code == tape::Code::iso));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/port-transfers", .role = Role::viewer,
                    .summary = "What went over ports, newest first: who, what revision, how long, outcome",
                    .response = "PortTransfers",
                    .query = with({{"port", "integer", "only this port"}, {"open", "boolean", "only those under way"}}, paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto port = call.number("port", 0);
                      const bool open = call.text("open") == "true";
                      const auto page = page_of(call);
                      auto list = co_await s.store.run(
                          [&](db::Database& db) { return db::port_transfers(db, {port, open}, page); });
                      for (const auto& view : s.dnc.views())
                        for (auto& row : list.items)
                          if (view.transfer && view.transfer->id == row.id) row = *view.transfer;
                      co_return json_reply(shape_list(list));
                    }});
  return routes;
}

awaitable<db::ReceivedRow> require_received(Services& s, std::int64_t id) {
  const auto row = co_await s.store.run([id](db::Database& db) { return db::received(db, id); });
  if (!row) throw Refused("not_found", "received");
  co_return *row;
}

std::vector<Route> receiving(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/received", .role = Role::viewer,
                    .summary = "What controls have punched, newest first", .response = "ReceivedList",
                    .query = with({{"state", "string", "waiting, same, accepted, rejected"}, {"port", "integer", "only this port"}}, paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto state = call.text("state");
                      const auto port = call.number("port", 0);
                      const auto page = page_of(call);
                      const auto list = co_await s.store.run(
                          [&](db::Database& db) { return db::received_rows(db, state, port, page); });
                      co_return json_reply(shape_list(list));
                    }});
  routes.push_back({.method = Method::get, .pattern = "/received/{id}/text", .role = Role::viewer,
                    .summary = "The text as it came, at most 1 MiB of it", .response = "ReceivedText",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await require_received(s, call.id("id"));
                      const auto blob = co_await s.store.run([&](db::Database& db) { return db::blob(db, row.sha256); });
                      if (!blob) throw Refused("not_found", "content");
                      const auto read = [&] {
                        const auto content = s.blobs.map(row.sha256);
                        return library::to_utf8(content->view().substr(0, 1u << 20), blob->encoding);
                      };
                      const std::string text = co_await s.workers.run(read);
                      co_return json_reply({{"text", text}, {"bytes", blob->bytes}, {"truncated", blob->bytes > (1 << 20)}});
                    }});
  routes.push_back({.method = Method::get, .pattern = "/received/{id}/diff", .role = Role::viewer,
                    .summary = "What differs from the revision in the library", .response = "Difference",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto row = co_await require_received(s, call.id("id"));
                      if (row.program == 0 || row.against_revision == 0) throw Refused("not_found", "revision");
                      const auto against = co_await s.store.run(
                          [&](db::Database& db) { return db::revision(db, row.program, row.against_revision); });
                      if (!against) throw Refused("not_found", "revision");
                      const auto compare = [&] {
                        const auto left = s.blobs.map(against->blob.sha256), right = s.blobs.map(row.sha256);
                        library::DiffOptions options;
                        options.context = 3;
                        return library::compare(left->view(), against->blob.encoding, right->view(), against->blob.encoding, options);
                      };
                      const auto difference = co_await s.workers.run(compare);
                      co_return json_reply(to_json(difference));
                    }});
  routes.push_back({.method = Method::post, .pattern = "/received/{id}/accept", .role = needs(Action::upload_program),
                    .summary = "A received program becomes a new revision, from machine; machine data become a set and values of the machine's pages",
                    .takes = Takes::json, .request = "Acceptance", .response = "Received",
                    .errors = {"already_decided", "bad_name", "bad_folder", "machine_not_read", "value_refused"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const dnc::Decision decision{call.body_text("why", ""), flag(call, "write")};
                      const auto actor = actor_of(call);
                      auto made = co_await s.store.run([&](db::Database& db) { return dnc::accept(db, s.blobs, actor, id, decision, db::now_ms()); });
                      auto& values = made.values;
                      if (values.request) values.request = co_await s.values.carry_out(*values.request);
                      if (values.written > 0) s.fleet.values_changed(made.row.machine);
                      json answer = shape(made.row);
                      if (made.row.kind != "program")
                        answer["values"] = {{"written", values.written}, {"differ", values.differ}, {"same", values.same},
                                            {"without_place", values.without_place},
                                            {"request", values.request ? json(values.request->id) : json(nullptr)},
                                            {"request_state", values.request ? json(values.request->state) : json(nullptr)},
                                            {"request_reason", values.request ? maybe_text(values.request->reason) : json(nullptr)}};
                      co_return json_reply(answer);
                    }});
  routes.push_back({.method = Method::post, .pattern = "/received/{id}/reject", .role = needs(Action::upload_program),
                    .summary = "Put a received text aside; the library stays as it is", .takes = Takes::json, .request = "Decision",
                    .response = "Received", .errors = {"already_decided"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto why = call.body_text("why", "");
                      const auto actor = actor_of(call);
                      const auto row = co_await s.store.run([&](db::Database& db) { return dnc::reject(db, actor, id, why, db::now_ms()); });
                      co_return json_reply(shape(row));
                    }});
  return routes;
}

}  // namespace

std::vector<Route> port_routes(Services& s) {
  return joined(s, {records, sending, receiving});
}

}  // namespace headstock::api
