// What a service refuses to do, as a code that the API and the browser turn into words. Thrown, not returned:
// a refusal in the middle of a transaction must undo it, and every service function would otherwise repeat
// that by hand.
#pragma once

#include <exception>
#include <span>
#include <string>
#include <string_view>

namespace headstock::db {

/// What kind of refusal it is: the API's status follows from it.
enum class RefusalKind {
  invalid,
  unauthenticated,
  forbidden,
  not_found,
  conflict,
  too_large,
  too_many,
  unavailable
};

struct RefusalText {
  std::string_view code;
  RefusalKind kind;
  std::string_view en, zh;
};

/// Every code a service can refuse with. One place, so that each has its words in both languages.
std::span<const RefusalText> refusal_texts();
/// @return nullptr for an unknown code.
const RefusalText* refusal_text(std::string_view code);

class Refusal : public std::exception {
 public:
  /// @param code must be in refusal_texts().
  /// @param where what it is about: a field, a name, a number; language-neutral.
  explicit Refusal(std::string code, std::string where = {});
  const std::string& code() const { return code_; }
  const std::string& where() const { return where_; }
  RefusalKind kind() const { return kind_; }
  const char* what() const noexcept override { return what_.c_str(); }

 private:
  std::string code_, where_, what_;
  RefusalKind kind_;
};

}  // namespace headstock::db
