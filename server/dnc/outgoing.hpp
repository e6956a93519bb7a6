// A stored program on its way to a line: a restart header in front when it begins in the middle, filtered, in
// the port's code. Looked through once on a worker before the first character goes out, so that nothing stops
// in the middle of a cut because of a character without a code.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "protocol/serial/sender.hpp"
#include "server/dnc/dnc.hpp"
#include "server/dnc/settings.hpp"

namespace headstock::dnc {

struct OutgoingText {
  std::string file;          ///< the blob; empty: only `header`
  std::string header;        ///< text in front
  std::uint64_t offset = 0;  ///< of the first byte of the file that is sent
};

struct OutgoingFacts {
  std::string reason,
      where;  ///< why it cannot be sent: no_code, numbers_are_used, blob_unreadable; empty: it can
  std::uint64_t bytes = 0;  ///< on the line
  std::string sha256;       ///< of these bytes
};

/// Worker. Reads it all.
OutgoingFacts examine(const OutgoingText& text, const PortSettings& settings);
/// What the first `bytes` characters of it were: their end as text, and the last line of the file that went
/// out whole. Worker. @param from_line where it begins; `text.offset`, when not 0, is that line's.
Tail tail_of(const OutgoingText& text, const PortSettings& settings, std::int64_t from_line,
             std::uint64_t bytes);
/// The same bytes, piece by piece.
std::unique_ptr<serial::Source> outgoing(const OutgoingText& text, const PortSettings& settings);

}  // namespace headstock::dnc
