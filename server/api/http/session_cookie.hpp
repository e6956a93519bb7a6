#pragma once

namespace headstock::api {

/// Name of the session cookie.
inline constexpr const char* session_cookie = "headstock_session";

}  // namespace headstock::api
