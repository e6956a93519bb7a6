// Any bytes: frames are cut, their bodies decoded as every message; nothing may crash, hang or take memory
// without bound.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "protocol/wire/frame.hpp"
#include "protocol/wire/messages.hpp"

namespace {

using namespace headstock::wire;

template <class Message>
void try_message(std::string_view body) {
  Message message;
  if (!decode(body, message).empty()) return;
  // What was accepted can be said again and is understood.
  Message again;
  if (!decode(encode(message), again).empty()) std::abort();
}

void try_all(std::string_view body) {
  nlohmann::json value;
  if (decode_json(body, value).empty()) (void)value.dump();
  try_message<Hello>(body);
  try_message<Welcome>(body);
  try_message<Refuse>(body);
  try_message<Ping>(body);
  try_message<Enrol>(body);
  try_message<Enrolled>(body);
  try_message<Command>(body);
  try_message<CommandResult>(body);
  try_message<TransferOpen>(body);
  try_message<Credit>(body);
  try_message<TransferResult>(body);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  try_all(bytes);
  FrameReader reader;
  Frame frame;
  std::string_view left = bytes;
  for (;;) {
    const auto status = reader.next(frame);
    if (status == FrameReader::Status::frame) {
      try_all(frame.body);
      continue;
    }
    if (status == FrameReader::Status::malformed || left.empty()) break;
    const auto into = reader.space();
    // Pieces of a size that the input chooses.
    const std::size_t piece =
        std::min({left.size(), into.size(), std::size_t{1} + static_cast<unsigned char>(left[0])});
    std::copy_n(left.data(), piece, into.data());
    reader.received(piece);
    left.remove_prefix(piece);
  }
  return 0;
}
