#include "server/dnc/settings.hpp"

#include <cctype>
#include <nlohmann/json.hpp>

#include "db/refusal.hpp"

namespace headstock::dnc {
namespace {

using nlohmann::json;

[[noreturn]] void bad(const std::string& field) {
  throw db::Refusal("bad_value", field);
}

void take(const json& from, const char* field, std::string& into) {
  if (!from.contains(field)) return;
  if (!from[field].is_string()) bad(field);
  into = from[field].get<std::string>();
}
void take(const json& from, const char* field, bool& into) {
  if (!from.contains(field)) return;
  if (!from[field].is_boolean()) bad(field);
  into = from[field].get<bool>();
}
template <class Number>
void take(const json& from, const char* field, Number& into, std::uint64_t least, std::uint64_t most) {
  if (!from.contains(field)) return;
  if (!from[field].is_number_integer()) bad(field);
  const auto value = from[field].get<std::int64_t>();
  if (value < 0 || static_cast<std::uint64_t>(value) < least || static_cast<std::uint64_t>(value) > most)
    bad(field);
  into = static_cast<Number>(value);
}

/// Without spaces, in capitals.
std::string plain(std::string_view text) {
  std::string found;
  for (const char c : text)
    if (c != ' ' && c != '\t' && c != '\r')
      found += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return found;
}

bool is_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.';
}

}  // namespace

json to_json(const PortSettings& settings) {
  const auto& link = settings.link;
  const auto& filter = settings.filter;
  return {{"protocol", link.protocol},
          {"line", serial::to_text(link.line)},
          {"code", tape::name_of(link.code)},
          {"symbols", link.symbols.text()},
          {"end_of_block", tape::name_of(link.end_of_block)},
          {"leader", link.leader},
          {"trailer", link.trailer},
          {"frame", link.frame},
          {"pad_for_tv", link.pad_for_tv},
          {"fold_case", link.fold_case},
          {"tv_check", link.tv_check},
          {"after_stop", link.after_stop},
          {"block_delay_ms", link.block_delay_ms},
          {"start_limit_s", link.start_limit_s},
          {"hold_limit_s", link.hold_limit_s},
          {"quiet_ms", link.quiet_ms},
          {"punch_limit_s", link.punch_limit_s},
          {"most_bytes", link.most_bytes},
          {"strip_spaces", filter.strip_spaces},
          {"strip_comments", filter.strip_comments},
          {"strip_empty", filter.strip_empty},
          {"number_from", filter.number_from},
          {"number_step", filter.number_step},
          {"header", filter.header}};
}

PortSettings settings_from(const json& from) {
  if (!from.is_object()) bad("settings");
  PortSettings settings;
  std::string text = "dc1-dc4";
  take(from, "protocol", text);
  if (serial::protocol_named(text) == nullptr) bad("protocol");
  auto& link = settings.link = serial::default_settings(text);
  auto& filter = settings.filter;
  if (from.contains("line")) {
    take(from, "line", text);
    const auto line = serial::settings_of(text);
    if (!line) bad("line");
    link.line = *line;
  }
  if (from.contains("code")) {
    take(from, "code", text);
    const auto code = tape::code_named(text);
    if (!code) bad("code");
    link.code = *code;
  }
  if (from.contains("end_of_block")) {
    take(from, "end_of_block", text);
    const auto form = tape::end_of_block_named(text);
    if (!form) bad("end_of_block");
    link.end_of_block = *form;
  }
  if (from.contains("symbols")) {
    take(from, "symbols", text);
    if (!link.symbols.read(text).empty()) bad("symbols");
  }
  take(from, "leader", link.leader, 0, 10'000);
  take(from, "trailer", link.trailer, 0, 10'000);
  take(from, "frame", link.frame);
  take(from, "pad_for_tv", link.pad_for_tv);
  take(from, "fold_case", link.fold_case);
  take(from, "tv_check", link.tv_check);
  take(from, "after_stop", link.after_stop, 3, 4'096);
  take(from, "block_delay_ms", link.block_delay_ms, 0, 60'000);
  take(from, "start_limit_s", link.start_limit_s, 0, 1'000'000);
  take(from, "hold_limit_s", link.hold_limit_s, 0, 1'000'000);
  take(from, "quiet_ms", link.quiet_ms, 100, 600'000);
  take(from, "punch_limit_s", link.punch_limit_s, 0, 1'000'000);
  take(from, "most_bytes", link.most_bytes, 1, 256ull << 20);
  take(from, "strip_spaces", filter.strip_spaces);
  take(from, "strip_comments", filter.strip_comments);
  take(from, "strip_empty", filter.strip_empty);
  take(from, "number_from", filter.number_from, 0, 99'999);
  take(from, "number_step", filter.number_step, 0, 1'000);
  take(from, "header", filter.header);
  if (filter.header.size() > 4'000) bad("header");
  return settings;
}

json to_json(const std::vector<RequestRule>& rules) {
  json list = json::array();
  for (const auto& rule : rules)
    list.push_back({{"pattern", rule.pattern},
                    {"action", rule.action == RequestRule::send ? "send" : "list"},
                    {"name", rule.name}});
  return list;
}

std::vector<RequestRule> rules_from(const json& from) {
  if (!from.is_array() || from.size() > 50) bad("rules");
  std::vector<RequestRule> rules;
  for (const auto& one : from) {
    RequestRule rule;
    if (!one.is_object()) bad("rules");
    take(one, "pattern", rule.pattern);
    take(one, "name", rule.name);
    std::string action = "send";
    take(one, "action", action);
    if (action != "send" && action != "list") bad("rules");
    rule.action = action == "send" ? RequestRule::send : RequestRule::list;
    const auto stars = [](const std::string& text) { return std::count(text.begin(), text.end(), '*'); };
    // A pattern of a few common characters would take ordinary punches for requests.
    if (plain(rule.pattern).size() < 4 || rule.pattern.size() > 100 || rule.name.size() > 100) bad("rules");
    if (rule.action == RequestRule::send &&
        (stars(rule.pattern) != 1 || stars(rule.name) > 1 || rule.name.empty()))
      bad("rules");
    if (rule.action == RequestRule::list && stars(rule.pattern) != 0) bad("rules");
    rules.push_back(std::move(rule));
  }
  return rules;
}

Wanted wanted(std::string_view text, const std::vector<RequestRule>& rules) {
  const std::string punched = plain(text.substr(0, 2'000));
  for (const auto& rule : rules) {
    const std::string pattern = plain(rule.pattern);
    const auto star = pattern.find('*');
    const auto front = pattern.substr(0, star);
    const auto at = punched.find(front);
    if (at == std::string::npos) continue;
    if (star == std::string::npos) return {&rule, rule.name};
    const auto begin = at + front.size();
    auto end = begin;
    while (end < punched.size() && end - begin < 64 && is_name(punched[end])) ++end;
    const auto back = std::string_view(pattern).substr(star + 1);
    if (end == begin || std::string_view(punched).substr(end, back.size()) != back) continue;
    std::string name = rule.name;
    if (const auto hole = name.find('*'); hole != std::string::npos)
      name.replace(hole, 1, punched.substr(begin, end - begin));
    return {&rule, name};
  }
  return {};
}

}  // namespace headstock::dnc
