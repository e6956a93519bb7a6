#include "protocol/serial/port/mark_decoder.hpp"

namespace headstock::serial {

std::vector<Fault> MarkDecoder::put(std::string_view bytes, std::string& data) {
  std::vector<Fault> faults;
  for (const char byte : bytes) {
    switch (state_) {
      case plain:
        if (byte == '\xFF') {
          state_ = mark;
        } else {
          data += byte;
        }
        break;
      case mark:
        state_ = byte == 0 ? zero : plain;
        if (byte != 0) data += byte;  // FF FF, or FF from a terminal that does not mark
        break;
      case zero:
        faults.push_back(byte == 0 ? Fault::line_break : Fault::parity);
        state_ = plain;
        break;
    }
  }
  return faults;
}

}  // namespace headstock::serial
