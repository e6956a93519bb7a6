// Unix time in milliseconds: the only form of time in the database.
#pragma once

#include <cstdint>
#include <string>

namespace headstock::db {

inline constexpr std::int64_t kHourMs = 3'600'000, kDayMs = 24 * kHourMs;

std::int64_t now_ms();
/// `2026-01-01T00:00:00.000Z`
std::string iso_time(std::int64_t ms);

}  // namespace headstock::db
