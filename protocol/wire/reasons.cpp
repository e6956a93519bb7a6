#include "protocol/wire/reasons.hpp"

#include "tables/reasons.hpp"

namespace headstock::protocol {

ReasonText reason_text(std::string_view key) {
  for (const auto& row : tables::reasons)
    if (row[0] == key) return {row[0], row[1], row[2]};
  return {key, key, key};
}

}  // namespace headstock::protocol
