// Any list of the interface as a table for a spreadsheet: `?format=csv` on every route that answers `{"items":[…]}`.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "server/api/http/router.hpp"

namespace headstock::api {

inline constexpr std::size_t csv_most_rows = 200'000;

/// UTF-8 with byte order mark (spreadsheets then read Chinese), comma, CRLF, first line the names. Objects become columns
/// `text.en`, arrays one cell with spaces; a text that a spreadsheet would take for a formula gets an apostrophe.
std::string csv_of(const nlohmann::json& items);

/// All pieces of the route's list, not only the first. Refused: bad_request (format: no list), too_many_rows.
boost::asio::awaitable<Reply> csv_reply(const Route& route, Call& call);

}  // namespace headstock::api
