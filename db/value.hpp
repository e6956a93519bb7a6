// Values that go into and come out of a database statement: null, integer, real and text, nothing else.
// Hashes are lower-case hex text, times are Unix milliseconds, so that every database keeps them alike.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace headstock::db {

class Value {
 public:
  using Storage = std::variant<std::nullptr_t, std::int64_t, double, std::string>;

  Value() = default;
  Value(std::nullptr_t) {}
  template <std::integral T>
  Value(T number) : storage_(static_cast<std::int64_t>(number)) {}
  Value(double number) : storage_(number) {}
  Value(std::string text) : storage_(std::move(text)) {}
  Value(std::string_view text) : storage_(std::string(text)) {}
  Value(const char* text) : storage_(std::string(text)) {}
  template <class T>
  Value(const std::optional<T>& maybe) {
    if (maybe) *this = Value(*maybe);
  }

  const Storage& storage() const { return storage_; }

 private:
  Storage storage_ = nullptr;
};

using Values = std::vector<Value>;

/// One row of a result, valid only inside the callback that receives it. Columns count from 0.
class Row {
 public:
  virtual ~Row() = default;
  virtual bool is_null(int column) const = 0;
  virtual std::int64_t integer(int column) const = 0;  ///< 0 when null
  virtual double real(int column) const = 0;           ///< 0 when null
  virtual std::string text(int column) const = 0;      ///< empty when null
  virtual Value value(int column) const = 0;           ///< as it is kept

  bool flag(int column) const { return integer(column) != 0; }
  std::optional<std::int64_t> maybe_integer(int column) const {
    return is_null(column) ? std::nullopt : std::optional(integer(column));
  }
  std::optional<double> maybe_real(int column) const {
    return is_null(column) ? std::nullopt : std::optional(real(column));
  }
  std::optional<std::string> maybe_text(int column) const {
    return is_null(column) ? std::nullopt : std::optional(text(column));
  }
};

}  // namespace headstock::db
