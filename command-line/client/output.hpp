// How the command line speaks: English or Chinese, tables for people, JSON for scripts.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace headstock::client {

/// Set once at the start: `--lang`, otherwise from LC_ALL, LC_MESSAGES, LANG.
void choose_language(const std::string& wanted);
bool chinese();
/// The text in the chosen language.
std::string say(std::string_view en, std::string_view zh);

using Line = std::vector<std::string>;
/// Columns aligned by display width (a Chinese character takes two).
std::string table(const Line& heads, const std::vector<Line>& rows);
/// Cells of a screen that a UTF-8 text takes.
std::size_t display_width(std::string_view text);

/// A value for a cell: texts as they are, null as "–".
std::string cell(const nlohmann::json& value);
/// `{"en":…,"zh":…}` in the chosen language.
std::string text_of(const nlohmann::json& both);
/// "2026-01-01 12:00:00" in local time from ISO 8601; "–" for null.
std::string local_time(const nlohmann::json& iso);
/// "1 h 02 min 03 s"
std::string duration(const nlohmann::json& seconds);
/// A machine's state as people say it.
std::string state_word(const std::string& state);

}  // namespace headstock::client
