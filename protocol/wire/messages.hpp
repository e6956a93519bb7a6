// The messages of the link as plain structs. `encode` makes the CBOR body of a frame, `decode` reads one from
// a peer that is not trusted: every field is present, of its type and within its bounds, or nothing is read
// at all.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace headstock::wire {

/// 1: agent → server, first on a connection.
struct Hello {
  std::vector<std::uint64_t> versions;  ///< of the link that this side speaks
  std::string software, name, profile;
  std::vector<std::string> axes;
  std::string boot_id;  ///< new at each start of the agent
  std::string spool_id;
  std::uint64_t acknowledged = 0;  ///< last event the agent knows to be committed at the server
  std::uint64_t memory_bytes = 0;
  std::string census_hash;
  std::string machine_toml;
  std::vector<std::uint64_t> transfers;  ///< drip-feeds this agent still holds, to be resumed
};
struct Welcome {
  std::uint64_t version = 1;
  std::int64_t server_time_ms = 0, machine = 0;
  std::uint64_t parts_required = 0;
};
struct Refuse {
  std::string reason, text;
  std::vector<std::uint64_t> versions;
};
struct Ping {
  std::uint64_t sequence = 0;
  std::int64_t time_ms = 0;
};
struct Enrol {
  std::string token, request_pem;
};  ///< token: the secret; empty for renew
struct Enrolled {
  std::string certificate_pem, ca_pem;
  std::int64_t machine = 0;
  std::string machine_name;
};
struct CertificateStored {
  std::string serial;
};  ///< hex; also the body of certificate_current
struct EventsAck {
  std::uint64_t sequence = 0;
};
struct Command {
  std::uint64_t id = 0;
  std::string action, name;
  double value = 0;
  std::string user;
};
struct CommandResult {
  std::uint64_t id = 0;
  bool accepted = false;
  std::string reason;
};
/// program_put, drip_open; the stream is in the frame's header.
struct TransferOpen {
  std::uint64_t transfer = 0;
  std::string name;
  std::uint64_t bytes = 0;
  std::string sha256;
};
struct ProgramGet {
  std::uint64_t transfer = 0;
  std::string name;
};
/// credit, drip_resume: `sha256` of the first `offset` bytes; the sender may send up to byte `offset +
/// granted`.
struct Credit {
  std::uint64_t transfer = 0, offset = 0;
  std::string sha256;
  std::uint64_t granted = 0;
};
struct DataEnd {
  std::uint64_t bytes = 0;
  std::string sha256;
};
struct TransferResult {
  std::uint64_t transfer = 0;
  bool ok = false;
  std::uint64_t bytes = 0;
  std::string sha256, reason;
};
/// transfer_cancel; transfer_closed (with an empty reason).
struct TransferCancel {
  std::uint64_t transfer = 0;
  std::string reason;
};

template <class Message>
std::string encode(const Message& message);
/// @return empty when `message` was read, otherwise what is wrong with the body.
template <class Message>
std::string decode(std::string_view body, Message& message);

/// Free-form bodies (live, events, census): `{key: value}` maps of the shapes of the README.
std::string encode_json(const nlohmann::json& value);
/// Reads CBOR from a peer that is not trusted: definite lengths, at most 16 deep and 200,000 items, texts in
/// UTF-8, no byte strings, tags or half-known simple values. @return empty when read, otherwise what is
/// wrong.
std::string decode_json(std::string_view body, nlohmann::json& value);

}  // namespace headstock::wire
