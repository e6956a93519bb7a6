#include <array>
#include <charconv>
#include <chrono>

#include "server/api/routes/routes.hpp"

namespace headstock::api {

const std::vector<Query> paging = {{"cursor", "string", "`next` of the piece before"},
                                   {"limit", "integer", "1…1000, 100 unless told"}};
const std::vector<Query> period = {{"from", "string", "time, inclusive"}, {"to", "string", "time, exclusive"}};

std::vector<Query> with(std::vector<Query> first, const std::vector<Query>& more) {
  first.insert(first.end(), more.begin(), more.end());
  return first;
}

Role needs(access::Action action) { return role_from(access::to_string(access::required(action))); }

access::Actor actor_of(const Call& call) {
  access::Actor actor;
  actor.user_id = call.who.user_id;
  actor.user = call.who.user;
  // A route without sign-in must not act as the server itself.
  actor.role = access::role_from(to_string(call.who.role)).value_or(access::Role::viewer);
  actor.address = call.request.peer;
  return actor;
}

db::Page page_of(const Call& call) {
  db::Page page;
  page.before = call.number("cursor", 0);
  const auto limit = call.number("limit", 100);
  if (page.before < 0) throw Refused("bad_request", "cursor");
  if (limit < 1 || limit > 1000) throw Refused("bad_request", "limit");
  page.limit = static_cast<int>(limit);
  return page;
}

namespace {

/// Reads exactly `digits` digits at the front of `text` and drops them.
bool take_number(std::string_view& text, std::size_t digits, int& out) {
  if (text.size() < digits) return false;
  const auto* end = text.data() + digits;
  const auto [at, error] = std::from_chars(text.data(), end, out);
  if (error != std::errc() || at != end || out < 0) return false;
  text.remove_prefix(digits);
  return true;
}

bool take(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

std::optional<std::int64_t> parse_time(const std::string& text) {
  if (text.size() > 10 && text.find_first_not_of("0123456789") == std::string::npos) {
    std::int64_t ms = 0;
    const auto [at, error] = std::from_chars(text.data(), text.data() + text.size(), ms);
    return error == std::errc() ? std::optional(ms) : std::nullopt;
  }
  std::string_view rest = text;
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, ms = 0;
  if (!take_number(rest, 4, year) || !take(rest, '-') || !take_number(rest, 2, month) || !take(rest, '-') ||
      !take_number(rest, 2, day))
    return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  if (!rest.empty()) {
    if (!take(rest, 'T') || !take_number(rest, 2, hour) || !take(rest, ':') || !take_number(rest, 2, minute))
      return std::nullopt;
    if (take(rest, ':') && !take_number(rest, 2, second)) return std::nullopt;
    if (take(rest, '.') && !take_number(rest, 3, ms)) return std::nullopt;
    if (!rest.empty() && !take(rest, 'Z')) return std::nullopt;
    if (!rest.empty() || hour > 23 || minute > 59 || second > 60) return std::nullopt;
  }
  using namespace std::chrono;
  const auto moment = sys_days(date) + hours(hour) + minutes(minute) + seconds(second) + milliseconds(ms);
  return duration_cast<milliseconds>(moment.time_since_epoch()).count();
}

std::optional<std::int64_t> time_of(const Call& call, const std::string& name) {
  const auto text = call.text(name);
  if (text.empty()) return std::nullopt;
  const auto time = parse_time(text);
  if (!time) throw Refused("bad_request", name);
  return time;
}

ReasonText reason_text(const std::string& reason) {
  struct Row {
    std::string_view key, en, zh;
  };
  static constexpr std::array<Row, 14> rows = {{
      {"not_armed", "Remote operation is not armed: the operator must arm it at the machine's own panel",
       "远程操作未许可：须由操作者在机床面板上许可"},
      {"not_connected", "The machine is not connected", "机床未连接"},
      {"timeout", "The machine did not answer in time; whether it acted is not known", "机床未及时应答，是否执行未知"},
      {"running", "The machine is running", "机床正在运行"},
      {"alarm", "The machine has an alarm; reset it first", "机床有报警，请先复位"},
      {"emergency_stop", "The machine is in emergency stop", "机床处于急停状态"},
      {"no_program", "No program is selected", "未选择程序"},
      {"not_found", "The machine has no such program", "机床中没有该程序"},
      {"memory_full", "The machine's program memory is full", "机床程序存储器已满"},
      {"bad_hash", "The program arrived damaged and was not kept", "程序传输损坏，未保存"},
      {"wrong_mode", "The machine is in another mode", "机床处于其他方式"},
      {"panel_only", "This is possible at the machine's own panel only", "只能在机床面板上操作"},
      {"bad_value", "The value is outside its range", "数值超出范围"},
      {"bad_name", "The machine cannot use this program name", "机床不能使用该程序名"},
  }};
  for (const auto& row : rows)
    if (row.key == reason) return {std::string(row.en), std::string(row.zh)};
  return {reason, reason};
}

Reply machine_refusal(const std::string& reason) {
  const auto text = reason_text(reason);
  return json_reply({{"accepted", false},
                     {"reason", reason},
                     {"error",
                      {{"code", "machine_refused"},
                       {"message", {{"en", text.en}, {"zh", text.zh}}},
                       {"where", reason}}}},
                    409);
}

void add_all_routes(Router& router, Services& services) {
  router.add(system_routes(services, router));
  router.add(session_routes(services));
  router.add(user_routes(services));
  router.add(machine_routes(services));
  router.add(history_routes(services));
  router.add(program_routes(services));
  router.add(revision_routes(services));
  router.add(transfer_routes(services));
}

}  // namespace headstock::api
