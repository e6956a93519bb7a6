// What a server's answer, or its absence, means for the person who asked.
#pragma once

#include <string>

#include "command-line/client/connection.hpp"

namespace headstock::client {

/// The answer's JSON (null when there is none). Throws Failure for every status but 2xx, in the server's words.
json demand_success(unsigned status, const std::string& body);

/// The failure of a server that cannot be reached, or is not whom it should be.
Failure cannot_connect(const std::string& url, const std::string& why);
Failure not_trusted(const std::string& why);
Failure bad_certificate_file(const std::string& file, const std::string& why);

}  // namespace headstock::client
