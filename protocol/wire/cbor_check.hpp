// Looks over a CBOR body before the library builds anything from it: depth, item count, lengths, UTF-8.
// Private to wire/.
#pragma once

#include <string>
#include <string_view>

namespace headstock::wire {

/// @return empty when the body is one well-formed item within the bounds, otherwise what is wrong.
std::string check_cbor(std::string_view body);
bool is_utf8(std::string_view text);

}  // namespace headstock::wire
