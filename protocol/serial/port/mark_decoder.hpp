// Undoes what a terminal set to mark errors (PARMRK) puts into its input: FF FF is a byte FF, FF 00 x a byte
// with an error, FF 00 00 a break (or a NUL with an error). Pieces may be cut anywhere.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "protocol/serial/faults.hpp"

namespace headstock::serial {

class MarkDecoder {
 public:
  /// Appends good bytes to `data`; a faulty byte is left out. @return the faults in `bytes`, parity for an
  /// error that the terminal does not name.
  std::vector<Fault> put(std::string_view bytes, std::string& data);

 private:
  enum { plain, mark, zero } state_ = plain;
};

}  // namespace headstock::serial
