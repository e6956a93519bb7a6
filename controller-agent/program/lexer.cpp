#include "program/lexer.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "program/characters.hpp"

namespace headstock::program {
namespace {

enum class Kind : std::uint8_t {
  illegal,
  letter,
  digit,
  blank,
  open,
  close,
  semicolon,
  slash,
  percent,
  sign,
  point,
  hash,
  bracket,
  colon,
  comma
};

constexpr std::array<Kind, 256> kKind = [] {
  std::array<Kind, 256> kinds{};
  for (int c = 'A'; c <= 'Z'; ++c) kinds[static_cast<std::size_t>(c)] = Kind::letter;
  for (int c = 'a'; c <= 'z'; ++c) kinds[static_cast<std::size_t>(c)] = Kind::letter;
  for (int c = '0'; c <= '9'; ++c) kinds[static_cast<std::size_t>(c)] = Kind::digit;
  // NUL and DEL are blank tape; a byte-order mark of an editor counts as blank too.
  for (const int c : {0x00, 0x09, 0x20, 0x7f, 0x0b, 0x0c, 0xef, 0xbb, 0xbf})
    kinds[static_cast<std::size_t>(c)] = Kind::blank;
  kinds['('] = Kind::open;
  kinds[')'] = Kind::close;
  kinds[';'] = Kind::semicolon;
  kinds['/'] = Kind::slash;
  kinds['%'] = Kind::percent;
  kinds['+'] = kinds['-'] = Kind::sign;
  kinds['.'] = Kind::point;
  kinds['#'] = Kind::hash;
  kinds['['] = Kind::bracket;
  kinds[':'] = Kind::colon;
  kinds[','] = Kind::comma;
  return kinds;
}();

Kind kind_of(char c) {
  return kKind[static_cast<unsigned char>(c)];
}

struct Number {
  Word word;
  bool negative = false;
  bool computed = false;  // by a macro expression: rules about written points do not apply
  std::uint16_t expression = 0;
  bool absent = false;  // a variable without a value
  bool valued = false;  // by an expression that was evaluated at once
};

class Scanner {
 public:
  Scanner(std::string_view line, const char* at, const LexRules& rules, Block& out)
      : begin_(line.data()), end_(line.data() + line.size()), at_(at), rules_(rules), out_(out) {}

  LexResult run() {
    out_.clear();
    bool at_head = true;
    for (;;) {
      while (at_ < end_ && kind_of(*at_) == Kind::blank) ++at_;
      if (at_ == end_) return done(at_);
      const char c = *at_;
      switch (kind_of(c)) {
        case Kind::letter:
          if (is_statement()) {
            if (!is_named_word()) return statement();
            if (!read_marked_word(rules_.named_letters)) return failed();
            at_head = false;
            break;
          }
          if (!read_word(static_cast<char>(c & ~0x20))) return failed();
          if ((c & ~0x20) != 'N') at_head = false;
          break;
        case Kind::colon:
          if (!read_word('O')) return failed();
          break;
        case Kind::comma:
          if (!read_marked_word(rules_.comma_letters)) return failed();
          at_head = false;
          break;
        case Kind::open:
          skip_comment();
          break;
        case Kind::close:  // without its opening: ignored (0i-D 13.1)
          ++at_;
          break;
        case Kind::semicolon:
          return done(rules_.semicolon_is_comment ? end_ : at_ + 1);
        case Kind::slash:
          if (!read_slash(at_head)) return failed();
          break;
        case Kind::percent: {
          LexResult result = done(end_);
          result.status = LexStatus::record_end;
          result.column = column();
          return result;
        }
        case Kind::hash:
          return statement();
        case Kind::bracket:  // [#NAME]=…
          if (rules_.expressions != nullptr && at_head) return statement();
          [[fallthrough]];
        case Kind::digit:
        case Kind::sign:
        case Kind::point:
          fail(LexError::no_address, at_);
          return failed();
        case Kind::illegal:
        case Kind::blank:
          fail(LexError::illegal_character, at_);
          return failed();
      }
    }
  }

 private:
  std::uint32_t column(const char* p) const { return static_cast<std::uint32_t>(p - begin_) + 1; }
  std::uint32_t column() const { return column(at_); }

  LexResult done(const char* rest) const {
    LexResult result;
    result.rest = rest;
    return result;
  }

  bool fail(LexError error, const char* where) {
    error_ = error;
    error_column_ = column(where);
    return false;
  }

  LexResult failed() const {
    LexResult result;
    result.status = LexStatus::error;
    result.error = error_;
    result.column = error_column_;
    result.rest = end_;
    return result;
  }

  // Two letters together never are a word of plain G code.
  bool is_statement() const { return at_ + 1 < end_ && kind_of(at_[1]) == Kind::letter; }

  // `NC` `NR` `NA`: another way to write `,C` `,R` `,A`. A third letter makes it a statement after all.
  bool is_named_word() const {
    const auto first = static_cast<char>(*at_ & ~0x20);
    const auto second = static_cast<char>(at_[1] & ~0x20);
    if (first != 'N' || (rules_.named_letters & letter_bit(second)) == 0) return false;
    return at_ + 2 == end_ || kind_of(at_[2]) != Kind::letter;
  }

  LexResult statement() {
    if ((out_.words | out_.g_count | out_.m_count) != 0 && rules_.expressions != nullptr) {
      fail(LexError::mixed_statement, at_);
      return failed();
    }
    LexResult result;
    result.status = LexStatus::statement;
    result.column = column();
    const char* stop = at_;
    for (bool in_comment = false; stop < end_; ++stop) {
      if (*stop == '(') in_comment = true;
      if (*stop == ')') in_comment = false;
      if (*stop == ';' && !in_comment) break;
    }
    result.statement = {at_, static_cast<std::size_t>(stop - at_)};
    result.rest = stop == end_ || rules_.semicolon_is_comment ? end_ : stop + 1;
    return result;
  }

  void skip_comment() {
    while (at_ < end_ && *at_ != ')') ++at_;
    if (at_ < end_) ++at_;
  }

  bool read_slash(bool at_head) {
    const char* slash = at_++;
    std::uint32_t which = 1;
    if (at_ < end_ && is_digit(*at_)) which = static_cast<std::uint32_t>(*at_++ - '0');
    if (at_head) {
      if (which == 0 || (at_ < end_ && *at_ == '/')) return fail(LexError::illegal_character, slash);
      out_.skip |= 1u << which;
    } else if (out_.inner_slash == 0) {
      out_.inner_slash = column(slash);
    }
    return true;
  }

  bool read_number(const char* letter, Number& out) {
    while (at_ < end_ && kind_of(*at_) == Kind::blank) ++at_;
    if (at_ == end_) return fail(LexError::no_data, letter);
    if (*at_ == '#' || *at_ == '[' || (at_ + 1 < end_ && *at_ == '-' && (at_[1] == '#' || at_[1] == '['))) {
      return read_expression(letter, out);
    }
    if (begins_function()) return read_expression(letter, out);
    if (*at_ == '-' || *at_ == '+') {
      out.negative = *at_ == '-';
      ++at_;
      while (at_ < end_ && *at_ == ' ') ++at_;
    }
    std::int64_t digits = 0;
    unsigned count = 0;
    unsigned decimals = 0;
    bool point = false;
    for (; at_ < end_; ++at_) {
      const auto d = static_cast<unsigned char>(*at_ - '0');
      if (d < 10) {
        if (++count > rules_.most_digits) return fail(LexError::too_many_digits, letter);
        if (point && decimals == static_cast<unsigned>(kNanoDecimals))
          continue;  // below what any control reads
        digits = digits * 10 + d;
        decimals += point ? 1u : 0u;
      } else if (*at_ == '.') {
        if (point) return fail(LexError::illegal_point, letter);
        point = true;
      } else {
        break;
      }
    }
    if (count == 0) return fail(LexError::no_data, letter);
    // Word::nano() holds nine digits before the point; a longer number must not wrap round into another
    // place.
    if (digits / kPowerOfTen[decimals] >= kNano) return fail(LexError::too_many_digits, letter);
    if (at_ < end_ && (*at_ == '-' || *at_ == '+')) return fail(LexError::illegal_minus, letter);
    out.word.digits = out.negative ? -digits : digits;
    out.word.decimals = static_cast<std::uint8_t>(decimals);
    out.word.digit_count = static_cast<std::uint8_t>(count);
    out.word.point = point;
    return true;
  }

  // `X-SQRT[#3]`: a function needs no brackets around it (0i-D L39842).
  bool begins_function() const {
    if (rules_.expressions == nullptr || !rules_.expressions->compiles()) return false;
    const char* at = at_ + (*at_ == '-' ? 1 : 0);
    const char* begin = at;
    while (at < end_ && kind_of(*at) == Kind::letter) ++at;
    return at - begin > 1 && at < end_ && *at == '[';
  }

  bool read_expression(const char* letter, Number& out) {
    if (rules_.expressions == nullptr) return fail(LexError::expression, letter);
    if (!rules_.expressions->compiles()) return read_value(letter, out);
    if (out_.computed_count == kMostComputed) return fail(LexError::too_many_words, letter);
    const LexError error = rules_.expressions->compile(at_, end_, out.expression);
    if (error != LexError::none) return fail(error, at_);
    out.word.digit_count = 1;
    out.word.point = true;
    out.computed = true;
    return true;
  }

  bool read_value(const char* letter, Number& out) {
    double value = 0;
    const LexError error = rules_.expressions->read(at_, end_, value, out.absent);
    if (error != LexError::none) return fail(error, letter);
    if (out.absent) return true;
    if (!(std::fabs(value) < 1e9)) return fail(LexError::too_many_digits, letter);
    out.negative = value < 0;
    out.word.digits = std::llround(value * static_cast<double>(kNano));
    out.word.decimals = kNanoDecimals;
    out.word.digit_count = 1;
    out.word.point = true;
    out.valued = true;
    return true;
  }

  void add_computed(char letter, std::size_t place, const Number& number, bool marked = false) {
    out_.computed[out_.computed_count++] = {letter, marked, static_cast<std::uint8_t>(place),
                                            number.expression};
  }

  // The word was there before: it is kept for macro calls, where every one counts.
  bool keep_earlier(char letter) {
    if (out_.earlier_count == kMostEarlier) return fail(LexError::too_many_words, at_);
    out_.earlier[out_.earlier_count++] = {out_.word[letter_index(letter)], letter,
                                          (out_.negative & letter_bit(letter)) != 0};
    for (std::size_t i = 0; i < out_.computed_count; ++i) {
      ComputedWord& computed = out_.computed[i];
      if (computed.letter == letter && computed.place == 0 && !computed.marked)
        computed.place = out_.earlier_count;
    }
    return true;
  }

  bool read_word(char letter) {
    const char* where = at_++;
    Number number;
    if (!read_number(where, number)) return false;
    if (number.absent) return true;
    Word& word = number.word;
    word.column = column(where);
    switch (letter) {
      case 'G':
        return add_code(out_.g, out_.g_count, number, where);
      case 'M':
        out_.m_pointed = out_.m_pointed || (word.point && !number.computed && !number.valued);
        return add_code(out_.m, out_.m_count, number, where);
      case 'N':
      case 'O':
        if (number.computed || number.valued) return fail(LexError::computed_number, where);
        if (number.negative || word.point || word.digit_count > 9)
          return fail(LexError::sequence_format, where);
        if (letter == 'N') {
          out_.has_sequence = true;
          out_.sequence = static_cast<std::uint32_t>(word.digits);
          out_.sequence_column = word.column;
        } else {
          out_.has_number = true;
          out_.number = static_cast<std::uint32_t>(word.digits);
          out_.number_column = word.column;
        }
        return true;
      default:
        break;
    }
    const std::uint32_t bit = letter_bit(letter);
    if ((out_.words & bit) != 0) {
      if (!keep_earlier(letter)) return false;
      out_.repeated |= bit;
    }
    if (number.computed) add_computed(letter, 0, number);
    out_.words |= bit;
    if (word.point && !number.computed && !number.valued)
      out_.pointed |= bit;
    else
      out_.pointed &= ~bit;
    if (number.negative)
      out_.negative |= bit;
    else
      out_.negative &= ~bit;
    out_.word[letter_index(letter)] = word;
    return true;
  }

  // `,C` `NC`: words of their own beside C. `at_` is at the mark.
  bool read_marked_word(std::uint32_t allowed) {
    const char* comma = at_++;
    while (at_ < end_ && kind_of(*at_) == Kind::blank) ++at_;
    if (at_ == end_ || kind_of(*at_) != Kind::letter) return fail(LexError::illegal_character, comma);
    const auto letter = static_cast<char>(*at_ & ~0x20);
    if ((allowed & letter_bit(letter)) == 0) return fail(LexError::illegal_character, comma);
    const char* where = at_++;
    Number number;
    if (!read_number(where, number)) return false;
    if (number.absent) return true;
    number.word.column = column(comma);
    if (number.computed) add_computed(letter, 0, number, true);
    out_.marked |= letter_bit(letter);
    out_.marked_word[letter_index(letter)] = number.word;
    return true;
  }

  bool add_code(std::array<Code, kMostCodes>& codes, std::uint8_t& count, const Number& number,
                const char* where) {
    if (number.negative) return fail(LexError::illegal_minus, where);
    if (count == kMostCodes) return fail(LexError::too_many_codes, where);
    if (number.computed) add_computed(codes.data() == out_.g.data() ? 'G' : 'M', count, number);
    const std::int64_t tenths = number.word.nano() / (kNano / 10);
    // Hundredths of a G code mean nothing to any of the controls: kept apart from every real code.
    const bool exact = number.word.nano() % (kNano / 10) == 0;
    codes[count++] = {exact && tenths < 1'000'000'000 ? static_cast<std::int32_t>(tenths) : -1,
                      column(where)};
    return true;
  }

  const char* begin_;
  const char* end_;
  const char* at_;
  const LexRules& rules_;
  Block& out_;
  LexError error_ = LexError::none;
  std::uint32_t error_column_ = 0;
};

}  // namespace

LexResult lex_block(std::string_view line, const char* at, const LexRules& rules, Block& out) {
  return Scanner(line, at, rules, out).run();
}

BlockHead read_head(std::string_view line, const char* at, const LexRules& rules) {
  const char* end = line.data() + line.size();
  BlockHead head;
  const auto read_number = [&](std::uint32_t& out) {
    std::uint64_t value = 0;
    for (++at; at < end && (is_digit(*at) || kind_of(*at) == Kind::blank); ++at) {
      if (is_digit(*at))
        value = std::min<std::uint64_t>(value * 10 + static_cast<unsigned>(*at - '0'), UINT32_MAX);
    }
    out = static_cast<std::uint32_t>(value);
  };
  for (bool more = true; more && at < end;) {
    switch (kind_of(*at)) {
      case Kind::blank:
        ++at;
        break;
      case Kind::open:
        while (at < end && *at != ')') ++at;
        if (at < end) ++at;
        break;
      case Kind::slash: {
        ++at;
        const std::uint32_t which = at < end && is_digit(*at) ? static_cast<std::uint32_t>(*at++ - '0') : 1u;
        head.skip |= 1u << which;
        break;
      }
      case Kind::percent:
        head.record_end = true;
        head.body = head.rest = end;
        return head;
      case Kind::colon:
        head.has_number = true;
        read_number(head.number);
        break;
      case Kind::letter: {
        const char letter = static_cast<char>(*at & ~0x20);
        if ((letter != 'N' && letter != 'O') || (at + 1 < end && kind_of(at[1]) == Kind::letter)) {
          more = false;
          break;
        }
        if (letter == 'N') {
          head.has_sequence = true;
          read_number(head.sequence);
        } else {
          head.has_number = true;
          read_number(head.number);
        }
        break;
      }
      default:
        more = false;
    }
  }
  head.body = at;
  for (bool in_comment = false; at < end; ++at) {
    if (*at == '(') in_comment = true;
    if (*at == ')') in_comment = false;
    if (*at == ';' && !in_comment) break;
  }
  head.rest = at == end || rules.semicolon_is_comment ? end : at + 1;
  return head;
}

}  // namespace headstock::program
