// The browser application's files, and a plain page where it was not built.
#pragma once

#include "server/api/http/message.hpp"

namespace headstock::api {

/// @param request a GET outside /api. A path that is no file but could be a page of the application gets its page.
Reply static_file(const Request& request);

}  // namespace headstock::api
