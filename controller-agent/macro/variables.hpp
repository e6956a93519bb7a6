// The variables a macro sees: locals by call level, commons, and by number everything the system answers for.
// Look-ahead thread.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "macro/rules.hpp"
#include "macro/value.hpp"

namespace headstock::macro {

/// #100…#999 in reach of a loop. What lasts is MachineData's; this is loaded from there and stored back.
class CommonVariables {
 public:
  static constexpr std::uint32_t kMost = 1'000;  ///< numbers are below

  CommonVariables() { values_.fill(kNull); }
  double get(std::uint32_t number) const { return number < kMost ? values_[number] : kNull; }
  void set(std::uint32_t number, double value) {
    if (number < kMost) values_[number] = value;
  }
  /// @param stored by number; what is not in it is <null>.
  void load(const std::map<std::uint32_t, double>& stored);

 private:
  friend class Variables;
  std::array<double, kMost> values_;
};

/// Who answers for the numbers from 1000 up: signals, positions, offsets, modal codes …
class SystemVariables {
 public:
  virtual ~SystemVariables() = default;
  /// `value` may become kNull (#3100).
  virtual Result read_system(std::uint32_t number, double& value) = 0;
  virtual Result write_system(std::uint32_t number, double value) = 0;
};

inline constexpr std::size_t kMostLocals = 64;

/// The locals of one call level and what ADP needs to know of the arguments.
struct LocalSet {
  std::array<double, kMostLocals> values;
  std::array<std::uint8_t, kMostLocals>
      implied_decimals{};  ///< decimals that an argument without a point got
  LocalSet() { values.fill(kNull); }
};

class Variables {
 public:
  Variables(const Rules& rules, CommonVariables& common, SystemVariables& system);

  Result read(std::uint32_t number, double& value) {
    if (number <= rules_.locals) {
      value = number == 0 && !zero_is_local_ ? kNull : locals->values[number];
      return {};
    }
    if (number < CommonVariables::kMost) {
      if (!is_common(number)) return Result::failed(Fault::macro_variable);
      value = common_.values_[number];
      return {};
    }
    return system_.read_system(number, value);
  }
  Result write(std::uint32_t number, double value) {
    if (number <= rules_.locals && (number != 0 || zero_is_local_)) {
      locals->values[number] = value;
      ++writes;
      return {};
    }
    return write_elsewhere(number, value);
  }
  /// #[…]: the nearest whole number. @return false when there is no such number.
  static bool number_of(double value, std::uint32_t& number);

  /// Commons changed since the last call: number and what was there before. Order: first change first.
  std::vector<std::pair<std::uint32_t, double>> take_changes();
  bool has_changes() const { return !changed_.empty(); }
  /// The program is left: whose locals were in force do not exist any more.
  void forget_locals() {
    main_ = LocalSet();
    locals = &main_;
  }
  /// Commons of a machine that never had any start as its controller's do.
  void power_on();
  /// Reset: everything that does not outlive it becomes <null>.
  void clear_volatile();

  bool is_common(std::uint32_t number) const {
    return (number >= rules_.common[0].first && number <= rules_.common[0].last) ||
           (number >= rules_.common[1].first && number <= rules_.common[1].last);
  }
  const Rules& rules() const { return rules_; }

  /// Names given by SETVN. @return kNoVariable when there is none.
  static constexpr std::uint32_t kNoVariable = UINT32_MAX;
  std::uint32_t named(std::string_view name) const;
  void name(std::uint32_t number, std::string text) { names_[number] = std::move(text); }
  const std::map<std::uint32_t, std::string>& names() const { return names_; }

  LocalSet* locals;                                   ///< of the level in force; never nullptr
  bool signed_angles = false;                         ///< see Rules::signed_angles_parameter
  bool eight_digits = false;                          ///< see Rules::eight_digits_parameter
  bool adp_refused = false;                           ///< see Rules::converted_arguments_parameter
  std::uint32_t protect_first = 0, protect_last = 0;  ///< write-protected commons; 0: none
  std::uint64_t writes = 0;                           ///< assignments made: a loop that makes none is endless

 private:
  Result write_elsewhere(std::uint32_t number, double value);

  const Rules& rules_;
  CommonVariables& common_;
  SystemVariables& system_;
  bool zero_is_local_ = false;
  LocalSet main_;
  std::map<std::uint32_t, std::string> names_;
  std::vector<std::pair<std::uint32_t, double>> changed_;
  std::array<bool, CommonVariables::kMost> is_changed_{};
};

}  // namespace headstock::macro
