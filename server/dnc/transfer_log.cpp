#include "server/dnc/transfer_log.hpp"

#include <initializer_list>
#include <map>

#include "db/machine_store.hpp"
#include "db/port_store.hpp"
#include "db/time.hpp"
#include "db/transfer_store.hpp"

namespace headstock::dnc {
namespace {

constexpr int kTransfersAtOnce = 1'000;

void row(std::string& out, std::initializer_list<std::string> values) {
  bool first = true;
  for (const auto& value : values) {
    if (!first) out += ',';
    first = false;
    out += csv_value(value);
  }
  out += "\r\n";
}

std::string time(const std::optional<std::int64_t>& ms) {
  return ms ? db::iso_time(*ms) : "";
}
std::string seconds(const std::optional<std::int64_t>& from, const std::optional<std::int64_t>& to) {
  if (!from || !to) return "";
  std::string text = std::to_string((*to - *from) / 1000);
  const auto rest = std::to_string((*to - *from) % 1000);
  return text + "." + std::string(3 - std::min<std::size_t>(rest.size(), 3), '0') + rest;
}
std::string maybe(std::int64_t id) {
  return id == 0 ? "" : std::to_string(id);
}

bool in_time(const LogWish& wish, std::int64_t created) {
  return created >= wish.from_ms && (wish.to_ms == 0 || created < wish.to_ms);
}

std::map<std::int64_t, std::string> machine_names(db::Database& db) {
  std::map<std::int64_t, std::string> names;
  for (const auto& machine : db::machines(db)) names[machine.id] = machine.name;
  return names;
}

void ports_piece(db::Database& db, const LogWish& wish, LogPlace& place, std::string& out) {
  std::map<std::int64_t, db::PortRow> ports;
  for (auto& port : db::ports(db)) ports[port.id] = port;
  const auto names = machine_names(db);
  const auto list =
      db::port_transfers(db, {wish.port, false, wish.from_ms, wish.to_ms}, {place.port_before, kTransfersAtOnce});
  for (const auto& one : list.items) {
    const auto port = ports.find(one.port);
    const auto machine = port == ports.end() ? 0 : port->second.machine;
    if (wish.machine != 0 && machine != wish.machine) continue;
    const auto name = names.find(machine);
    row(out, {"port",
              std::to_string(one.id),
              port == ports.end() ? std::to_string(one.port) : port->second.name,
              name == names.end() ? "" : name->second,
              one.kind,
              one.name,
              maybe(one.revision),
              one.sha256,
              std::to_string(one.from_line),
              std::to_string(one.bytes),
              maybe(one.total),
              one.wire_sha256,
              one.state,
              one.reason,
              one.detail,
              one.by,
              db::iso_time(one.created_ms),
              time(one.started_ms),
              time(one.ended_ms),
              seconds(one.started_ms, one.ended_ms)});
  }
  place.ports_done = !list.next;
  place.port_before = list.next.value_or(0);
}

void agents_piece(db::Database& db, const LogWish& wish, LogPlace& place, std::string& out) {
  const auto names = machine_names(db);
  db::TransferFilter filter;
  filter.machine = wish.machine;
  const auto list = db::transfers(db, filter, {place.agent_before, kTransfersAtOnce});
  for (const auto& one : list.items) {
    if (!in_time(wish, one.created_ms)) continue;
    const auto name = names.find(one.machine);
    row(out, {"agent",
              std::to_string(one.id),
              "",
              name == names.end() ? std::to_string(one.machine) : name->second,
              one.kind,
              one.name,
              maybe(one.revision),
              one.sha256,
              "1",
              std::to_string(one.bytes),
              maybe(one.total),
              one.state == "done" ? one.sha256 : "",
              one.state,
              one.reason,
              "",
              one.by,
              db::iso_time(one.created_ms),
              time(one.started_ms),
              time(one.ended_ms),
              seconds(one.started_ms, one.ended_ms)});
  }
  place.agents_done = !list.next;
  place.agent_before = list.next.value_or(0);
}

}  // namespace

std::string csv_value(const std::string& text) {
  const bool formula =
      !text.empty() && std::string_view("=+-@\t\r").find(text.front()) != std::string_view::npos;
  std::string value = formula ? "'" + text : text;
  if (value.find_first_of(",\"\r\n") == std::string::npos) return value;
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string log_head() {
  return "over,id,port,machine,kind,name,revision,sha256,from_line,bytes,total,line_sha256,outcome,reason,"
         "detail,by,"
         "created,started,ended,seconds\r\n";
}

bool append_log(db::Database& db, const LogWish& wish, LogPlace& place, std::string& out) {
  if (!place.ports_done)
    ports_piece(db, wish, place, out);
  else if (!place.agents_done && wish.port == 0)
    agents_piece(db, wish, place, out);
  else
    return false;
  return true;
}

}  // namespace headstock::dnc
