// Builds the WHERE of a list from the conditions that were asked for. Only for the stores.
#pragma once

#include <algorithm>
#include <string>

#include "db/database.hpp"
#include "db/page.hpp"

namespace headstock::db {

class Where {
 public:
  void add(const std::string& condition, Value value) {
    text_ += (text_.empty() ? " WHERE " : " AND ") + condition;
    values_.push_back(std::move(value));
  }
  void add(const std::string& condition) { text_ += (text_.empty() ? " WHERE " : " AND ") + condition; }
  /// One value used for several question marks.
  void add_repeated(const std::string& condition, const Value& value, int times) {
    add(condition);
    values_.insert(values_.end(), static_cast<std::size_t>(times), value);
  }
  void page(const std::string& id, const Page& page) {
    if (page.before > 0) add(id + " < ?", page.before);
  }
  const std::string& text() const { return text_; }
  const Values& values() const { return values_; }

 private:
  std::string text_;
  Values values_;
};

/// `%part%` for LIKE … ESCAPE '\'.
inline std::string like_part(const std::string& text) {
  std::string pattern = "%";
  for (const char c : text) {
    if (c == '%' || c == '_' || c == '\\') pattern += '\\';
    pattern += c;
  }
  return pattern + "%";
}

/// Runs a newest-first list query and cuts it into a page.
template <class T, class Make, class Id>
Listed<T> listed(Database& db, const std::string& select, const Where& where, const std::string& id_column,
                 const Page& page, Make make, Id id) {
  const int limit = std::clamp(page.limit, 1, 1000);
  Listed<T> list;
  db.each(select + where.text() + " ORDER BY " + id_column + " DESC LIMIT " + std::to_string(limit + 1),
          where.values(), [&](const Row& row) { list.items.push_back(make(row)); });
  if (list.items.size() > static_cast<std::size_t>(limit)) {
    list.items.pop_back();
    list.next = id(list.items.back());
  }
  return list;
}

}  // namespace headstock::db
