#include "db/postgres_sql.hpp"

#include <algorithm>
#include <cctype>
#include <vector>

#include "db/database.hpp"

namespace headstock::db {
namespace {

struct Token {
  enum class Kind { word, quoted, space, sign } kind;
  std::string text;
  std::string upper;  ///< of words
};
using Tokens = std::vector<Token>;

bool word_part(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

/// Where the piece that begins at `at` ends, and what it is.
std::size_t end_of(std::string_view sql, std::size_t at, Token::Kind& kind) {
  const char c = sql[at];
  std::size_t end = at + 1;
  if (c == '\'' || c == '"') {
    kind = Token::Kind::quoted;
    // A doubled quote is read as two quoted pieces, which print the same.
    while (end < sql.size() && sql[end] != c) ++end;
    return std::min(end + 1, sql.size());
  }
  if (c == '-' && end < sql.size() && sql[end] == '-') {
    kind = Token::Kind::space;
    return std::min(sql.find('\n', at), sql.size());
  }
  if (std::isspace(static_cast<unsigned char>(c)) != 0) {
    kind = Token::Kind::space;
    while (end < sql.size() && std::isspace(static_cast<unsigned char>(sql[end])) != 0) ++end;
    return end;
  }
  if (word_part(c)) {
    kind = Token::Kind::word;
    while (end < sql.size() && word_part(sql[end])) ++end;
    return end;
  }
  kind = Token::Kind::sign;
  return end;
}

Tokens tokens_of(std::string_view sql) {
  Tokens tokens;
  for (std::size_t at = 0; at < sql.size();) {
    Token::Kind kind{};
    const std::size_t end = end_of(sql, at, kind);
    Token token{kind, std::string(sql.substr(at, end - at)), {}};
    if (kind == Token::Kind::word) {
      token.upper = token.text;
      std::ranges::transform(token.upper, token.upper.begin(),
                             [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    }
    tokens.push_back(std::move(token));
    at = end;
  }
  return tokens;
}

/// Index of the next token that is not space; tokens.size() at the end.
std::size_t next(const Tokens& tokens, std::size_t at) {
  while (++at < tokens.size() && tokens[at].kind == Token::Kind::space) {
  }
  return at;
}

bool is_word(const Tokens& tokens, std::size_t at, std::string_view word) {
  return at < tokens.size() && tokens[at].upper == word;
}
bool is_sign(const Tokens& tokens, std::size_t at, std::string_view sign) {
  return at < tokens.size() && tokens[at].kind == Token::Kind::sign && tokens[at].text == sign;
}

/// How many values stand in the brackets that open at `open`.
int values_in(const Tokens& tokens, std::size_t open) {
  int depth = 0, commas = 0;
  for (std::size_t at = open; at < tokens.size(); ++at) {
    if (is_sign(tokens, at, "(")) ++depth;
    if (is_sign(tokens, at, ")") && --depth == 0) break;
    if (is_sign(tokens, at, ",") && depth == 1) ++commas;
  }
  return commas + 1;
}

/// What both kinds of text share.
std::string plain_word(const Tokens& tokens, std::size_t at) {
  const Token& token = tokens[at];
  if (token.upper == "USER") return "\"user\"";
  if (token.upper == "LIKE") return "ILIKE";
  if (token.upper == "MAX" || token.upper == "MIN") {
    const std::size_t open = next(tokens, at);
    if (is_sign(tokens, open, "(") && values_in(tokens, open) > 1)
      return token.upper == "MAX" ? "GREATEST" : "LEAST";
  }
  return token.text;
}

std::string type_of(const std::string& upper) {
  if (upper == "INTEGER") return "BIGINT";
  if (upper == "REAL") return "DOUBLE PRECISION";
  if (upper == "BLOB") return "BYTEA";
  return {};
}

/// `CREATE TRIGGER name BEFORE … ON table [WHEN …] BEGIN SELECT RAISE(ABORT, 'why'); END`, from `at`, the word CREATE.
/// @return the index after it.
std::size_t trigger(const Tokens& tokens, std::size_t at, std::string& out) {
  std::size_t end = at;
  std::string head, condition;
  bool in_condition = false;
  for (; end < tokens.size() && !is_word(tokens, end, "BEGIN"); ++end) {
    if (is_word(tokens, end, "FOR") && is_word(tokens, next(tokens, end), "EACH")) {
      end = next(tokens, next(tokens, end));  // FOR EACH ROW: said again below
      continue;
    }
    if (is_word(tokens, end, "WHEN")) {
      in_condition = true;
      continue;
    }
    (in_condition ? condition : head) += tokens[end].kind == Token::Kind::word ? plain_word(tokens, end) : tokens[end].text;
  }
  // SELECT RAISE ( ABORT , 'why' ) ; END
  std::vector<std::size_t> body;
  for (std::size_t i = next(tokens, end); i < tokens.size() && body.size() < 9; i = next(tokens, i)) body.push_back(i);
  std::string why;
  std::size_t last = 0;
  if (body.size() >= 9 && is_word(tokens, body[0], "SELECT") && is_word(tokens, body[1], "RAISE")) {
    std::size_t i = body[5];
    for (; i < tokens.size() && tokens[i].kind == Token::Kind::quoted; ++i) why += tokens[i].text;
    while (i < tokens.size() && !is_word(tokens, i, "END")) ++i;
    last = i;
  }
  if (why.empty() || last >= tokens.size())
    throw Error(Problem::internal, "a trigger that only SQLite understands: " + head);
  out += head + " FOR EACH ROW ";
  if (!condition.empty()) out += "WHEN (" + condition + ") ";
  out += "EXECUTE FUNCTION headstock_refuse(" + why + ")";
  return last + 1;
}

}  // namespace

std::string postgres_statement(std::string_view sql) {
  const Tokens tokens = tokens_of(sql);
  std::string out;
  int parameter = 0;
  for (std::size_t at = 0; at < tokens.size(); ++at) {
    if (is_sign(tokens, at, "?"))
      out.append("$").append(std::to_string(++parameter));
    else
      out += tokens[at].kind == Token::Kind::word ? plain_word(tokens, at) : tokens[at].text;
  }
  return out;
}

std::string postgres_script(std::string_view sql) {
  const Tokens tokens = tokens_of(sql);
  std::string out;
  for (std::size_t at = 0; at < tokens.size();) {
    if (is_word(tokens, at, "CREATE") && is_word(tokens, next(tokens, at), "TRIGGER")) {
      at = trigger(tokens, at, out);
      continue;
    }
    if (is_word(tokens, at, "INTEGER") && is_word(tokens, next(tokens, at), "PRIMARY")) {
      const std::size_t key = next(tokens, next(tokens, at)), after = next(tokens, key);
      out += "BIGINT GENERATED BY DEFAULT AS IDENTITY PRIMARY KEY";
      at = is_word(tokens, after, "AUTOINCREMENT") ? after + 1 : key + 1;
      continue;
    }
    const std::string type = type_of(tokens[at].upper);
    if (!type.empty())
      out += type;
    else
      out += tokens[at].kind == Token::Kind::word ? plain_word(tokens, at) : tokens[at].text;
    ++at;
  }
  return out;
}

}  // namespace headstock::db
