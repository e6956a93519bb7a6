// Everything the server knows of one machine as files of an archive: who it is, its machine file (axes, limits, ladder),
// every value of its pages, the programs in its memory. Also what of it can go back to a machine.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "db/blobs.hpp"
#include "db/machine_store.hpp"
#include "server/backup/archive.hpp"

namespace headstock::backup {

struct MachineContent {
  db::MachineRow machine;
  std::vector<db::ResidentRow> programs;
  std::map<std::string, double> values;  ///< offsets, tool life, parameters, variables as the machine last told
};
/// Store thread. Refusals: not_found.
MachineContent machine_content(db::Database& db, std::int64_t machine);

/// Worker thread. @return manifest facts, among them `not_here`: resident programs whose text the server never had.
nlohmann::json write_machine(ArchiveWriter& archive, const MachineContent& content, const db::Blobs& blobs);

/// Reads a verified archive; the programs' texts go into the blobs. Refusals: damaged_backup, not_a_backup (another kind).
struct MachineArchive {
  nlohmann::json manifest;
  std::string name, profile, toml;
  std::map<std::string, double> values;
  struct Program {
    std::string name;
    std::string sha256;
    bool selected = false;
  };
  std::vector<Program> programs;
};
MachineArchive read_machine(const std::filesystem::path& file, const db::Blobs& blobs);

}  // namespace headstock::backup
