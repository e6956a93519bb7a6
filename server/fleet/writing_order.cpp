#include "server/fleet/writing_order.hpp"

#include <algorithm>
#include <charconv>
#include <tuple>

namespace headstock::fleet {
namespace {

constexpr std::string_view kLife = "tool_life/";

long number_in(std::string_view text, long otherwise) {
  long value = otherwise;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? value : otherwise;
}

using Rank = std::tuple<int, long, long>;  // round, group, tool

Rank rank_of(std::string_view what, bool is_removed) {
  if (what.starts_with("parameter/")) return {0, 0, 0};
  const LifePlace place = life_place(what);
  if (place.group == 0) return {1, 0, 0};
  if (place.field == "unit") return {2, place.group, 0};
  if (place.field == "life") return {3, place.group, 0};
  if (place.field != "tool") return {5, place.group, place.index};
  return is_removed ? Rank{6, place.group, -place.index} : Rank{4, place.group, place.index};
}

}  // namespace

LifePlace life_place(std::string_view what) {
  if (!what.starts_with(kLife)) return {};
  what.remove_prefix(kLife.size());
  const auto first = what.find('/');
  if (first == what.npos) return {};
  LifePlace place;
  place.group = number_in(what.substr(0, first), 0);
  what.remove_prefix(first + 1);
  const auto second = what.find('/');
  place.field = what.substr(0, second);
  if (second != what.npos) place.index = number_in(what.substr(second + 1), -1);
  return place;
}

std::vector<std::pair<std::string, double>> in_writing_order(const db::MachineValues& values) {
  std::vector<std::pair<std::string, double>> sorted(values.begin(), values.end());
  std::ranges::stable_sort(sorted, {}, [](const auto& one) { return rank_of(one.first, false); });
  return sorted;
}

void put_in_writing_order(std::vector<db::ValueItem>& items) {
  std::ranges::stable_sort(items, {}, [](const db::ValueItem& one) { return rank_of(one.what, !one.after); });
}

}  // namespace headstock::fleet
