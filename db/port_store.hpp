// Serial ports, what was sent and received over them, and what waits for approval. Plain rows; the rules are
// in server/dnc. Store thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "db/database.hpp"
#include "db/page.hpp"

namespace headstock::db {

struct PortRow {
  std::int64_t id = 0;
  std::string name;
  std::int64_t machine = 0;   ///< what stands at the other end; 0: not a machine of ours
  std::string address;        ///< /dev/ttyS0, tcp://HOST:PORT, rfc2217://HOST:PORT
  std::string settings_json;  ///< serial::LinkSettings
  bool listens = false;       ///< kept open; what a control punches is taken, its requests are answered
  std::string folder = "/";   ///< where received programs belong
  std::string name_rule = "number";
  std::string rules_json = "[]";  ///< requests from the control
  std::int64_t created_ms = 0, changed_ms = 0;
};

std::vector<PortRow> ports(Database& db);
std::optional<PortRow> port(Database& db, std::int64_t id);
std::optional<PortRow> port_named(Database& db, const std::string& name);
std::int64_t insert_port(Database& db, const PortRow& port);
void update_port(Database& db, const PortRow& port);
void remove_port(Database& db, std::int64_t id, std::int64_t at_ms);

/// A certificate of what went over a line.
struct PortTransferRow {
  std::int64_t id = 0, port = 0;
  std::string kind;   ///< send drip receive answer
  std::string state;  ///< queued waiting sending held paused draining receiving done failed cancelled
  std::int64_t program = 0, revision = 0;
  std::string name, sha256;  ///< of the stored content
  std::int64_t from_line = 1;
  std::string header;                 ///< sent in front when it began in the middle
  std::int64_t bytes = 0, total = 0;  ///< characters on the line; total 0: not known before
  std::string wire_sha256;            ///< of what was handed to the line
  std::string reason, detail;         ///< message key; what the system said
  std::string figures_json = "{}";
  std::string by;
  std::int64_t created_ms = 0;
  std::optional<std::int64_t> started_ms, ended_ms;
  std::string settings_json = "{}";  ///< of the port at the time: code, filters, handshake
};
std::int64_t insert_port_transfer(Database& db, const PortTransferRow& row);
/// Writes state, bytes, total, wire_sha256, reason, detail, figures, started and ended.
void update_port_transfer(Database& db, const PortTransferRow& row);
std::optional<PortTransferRow> port_transfer(Database& db, std::int64_t id);
struct PortTransferFilter {
  std::int64_t port = 0;  ///< 0: all
  bool open_only = false;
  std::int64_t from_ms = 0, to_ms = 0;  ///< created in [from, to); 0: no limit
};
Listed<PortTransferRow> port_transfers(Database& db, const PortTransferFilter& filter, const Page& page);
/// What an earlier run of the server left open has ended: nothing goes on by itself. @return how many.
std::int64_t end_open_port_transfers(Database& db, const std::string& reason, std::int64_t at_ms);

/// What lies in a machine by what went over its port: the newest whole program of each name that was sent,
/// and the newest that was punched back.
struct PortResidentRow {
  std::string name, sha256;
  std::int64_t program = 0, revision = 0;  ///< 0: not known to the library
  std::string classes;                     ///< of a punch: what differs from `revision`
  bool punched = false;
  std::int64_t since_ms = 0, record = 0;  ///< id of the transfer, or of the received piece
};
std::vector<PortResidentRow> port_residents(Database& db, std::int64_t port);

/// What a port has learnt about its line, over all its transfers.
struct PortMeasuresRow {
  std::int64_t port = 0, transfers = 0, stops = 0;
  std::int64_t most_after_stop = 0;  ///< characters under way when a DC3 came, worst
  std::int64_t longest_stop_us = 0;  ///< until they were out
  std::int64_t longest_hold_ms = 0, starved_ms = 0, sending_ms = 0;
  std::int64_t round_trip_us = 0;  ///< of one character, by the loop-back test; 0: not measured
  std::int64_t at_ms = 0;
};
std::optional<PortMeasuresRow> port_measures(Database& db, std::int64_t port);
void put_port_measures(Database& db, const PortMeasuresRow& row);

struct ReceivedRow {
  std::int64_t id = 0, port = 0, transfer = 0, machine = 0;
  std::string
      kind;  ///< program, tool_offsets, work_offsets, parameters, pitch_error, macro_variables, tool_life
  std::string name, comment, sha256;
  bool closed = false;  ///< ended as a punch should
  std::string folder;
  std::int64_t program = 0, against_revision = 0;  ///< 0: no program of this name in the folder
  std::string
      classes;  ///< kinds of change against it, comma separated; empty: none, or nothing to compare with
  std::string state = "waiting";  ///< waiting, same (nothing to decide), accepted, rejected
  std::string decided_by, decided_why;
  std::optional<std::int64_t> decided_ms;
  std::int64_t at_ms = 0;
};
std::int64_t insert_received(Database& db, const ReceivedRow& row);
/// Writes state and decision.
void update_received(Database& db, const ReceivedRow& row);
std::optional<ReceivedRow> received(Database& db, std::int64_t id);
Listed<ReceivedRow> received_rows(Database& db, const std::string& state, std::int64_t port,
                                  const Page& page);

}  // namespace headstock::db
