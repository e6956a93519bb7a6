// A message out of a frame, or the end of a connection whose peer does not send what the frame says it is.
#pragma once

#include <string>

#include "protocol/wire/connection.hpp"
#include "protocol/wire/messages.hpp"

namespace headstock::wire {

/// Calls `handler` with the message in the frame; a malformed one closes the connection with a reason.
template <class Message, class Handler>
void expect(Connection& connection, const Frame& frame, Handler handler) {
  Message message;
  const std::string wrong = decode(frame.body, message);
  if (wrong.empty())
    handler(message);
  else
    connection.close("message " + std::to_string(static_cast<int>(frame.type)) + ": " + wrong);
}

}  // namespace headstock::wire
