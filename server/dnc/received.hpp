// What a control has punched becomes records that wait for a person: split into programs and machine data,
// compared with what is released. The library is untouched until somebody accepts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "db/blobs.hpp"
#include "db/port_store.hpp"
#include "db/program_store.hpp"
#include "protocol/tape/finding.hpp"
#include "server/access/role.hpp"
#include "server/dnc/settings.hpp"
#include "server/fleet/punched.hpp"
#include "server/library/difference.hpp"

namespace headstock::dnc {

struct Punch {
  std::string reason,
      where;         ///< why nothing is kept: punch_empty, punch_parity, too_many_programs; empty: good
  std::string text;  ///< decoded
  struct Piece {
    db::ReceivedRow row;  ///< kind, name, comment, sha256, closed
    db::BlobRow blob;
  };
  std::vector<Piece> pieces;
};

/// Worker: decodes, splits, stores the pieces' texts as blobs (content without a record is harmless).
Punch take_apart(const std::string& bytes, bool closed, const PortSettings& settings, const db::PortRow& port,
                 const db::Blobs& blobs);

/// Store thread: compares each with the program of its name and writes the records. @return their ids.
std::vector<std::int64_t> keep(db::Database& db, const db::Blobs& blobs, Punch punch, const db::PortRow& port,
                               std::int64_t transfer, std::int64_t now_ms);

struct Decision {
  std::string why;
  /// Machine data of a machine with an agent: ask that what differs be written into it.
  bool write = false;
};
struct Acceptance {
  db::ReceivedRow row;
  fleet::PunchedOutcome values;  ///< of machine data; its request, if any, is still to be sent
};
/// A received program becomes a new revision (origin "machine:N" or "port:N"), machine data a set of its
/// machine (db/plan_store.hpp) and values of its pages (server/fleet/punched.hpp). Refusals: forbidden,
/// not_found, already_decided, those of take_punched; nothing is accepted then.
Acceptance accept(db::Database& db, const db::Blobs& blobs, const access::Actor& actor, std::int64_t id,
                  const Decision& decision, std::int64_t now_ms);
db::ReceivedRow reject(db::Database& db, const access::Actor& actor, std::int64_t id, const std::string& why,
                       std::int64_t now_ms);

}  // namespace headstock::dnc
