#include "macro/variables.hpp"

#include <cmath>
#include <utility>

namespace headstock::macro {

void CommonVariables::load(const std::map<std::uint32_t, double>& stored) {
  values_.fill(kNull);
  for (const auto& [number, value] : stored) set(number, value);
}

Variables::Variables(const Rules& rules, CommonVariables& common, SystemVariables& system)
    : locals(&main_), rules_(rules), common_(common), system_(system) {}

bool Variables::number_of(double value, std::uint32_t& number) {
  const double nearest = std::floor(or_zero(value) + 0.5);
  if (!(nearest >= 0 && nearest < 4e9)) return false;
  number = static_cast<std::uint32_t>(nearest);
  return true;
}

Result Variables::write_elsewhere(std::uint32_t number, double value) {
  if (number == 0) return Result::failed(Fault::macro_protected);
  ++writes;
  if (number >= CommonVariables::kMost) {
    return system_.write_system(number, or_zero(value));  // <null> becomes 0 there (L13610)
  }
  if (!is_common(number)) return Result::failed(Fault::macro_variable);
  if (number >= protect_first && number <= protect_last) return Result::failed(Fault::macro_protected);
  double& place = common_.values_[number];
  if (!is_changed_[number]) {
    is_changed_[number] = true;
    changed_.emplace_back(number, place);
  }
  place = value;
  return {};
}

std::vector<std::pair<std::uint32_t, double>> Variables::take_changes() {
  for (const auto& [number, before] : changed_) is_changed_[number] = false;
  return std::exchange(changed_, {});
}

void Variables::power_on() {
  if (!rules_.retained_start_at_zero) return;
  for (const CommonRange& range : rules_.common) {
    if (!range.retained) continue;
    bool used = false;
    for (std::uint32_t n = range.first; n <= range.last; ++n) used = used || !is_null(common_.values_[n]);
    for (std::uint32_t n = range.first; n <= range.last && !used; ++n) (void)write_elsewhere(n, 0);
  }
}

void Variables::clear_volatile() {
  for (const CommonRange& range : rules_.common) {
    if (range.retained) continue;
    for (std::uint32_t number = range.first; number <= range.last; ++number) {
      if (!is_null(common_.values_[number])) (void)write_elsewhere(number, kNull);
    }
  }
}

std::uint32_t Variables::named(std::string_view wanted) const {
  for (const auto& [number, text] : names_) {  // the lower number when two have the same name (L13787)
    if (text == wanted) return number;
  }
  return kNoVariable;
}

}  // namespace headstock::macro
