#include "server/backup/machine_backup.hpp"

#include <algorithm>

#include "db/refusal.hpp"
#include "db/time.hpp"

namespace headstock::backup {
namespace {

using nlohmann::json;

bool on_disk(const db::Blobs& blobs, const std::string& sha256) {
  std::error_code ignored;
  return sha256.size() == 64 && std::filesystem::exists(blobs.path(sha256), ignored);
}

/// `offsets.json` and the like name values; both tables have been theirs.
std::map<std::string, double> values_of(db::Database& db, std::int64_t machine) {
  std::map<std::string, double> values;
  const char* const sql = db.has_table("machine_values")
                              ? "SELECT what, value FROM machine_values WHERE machine_id = ? AND value IS NOT NULL"
                              : "SELECT what, value FROM offsets WHERE machine_id = ?";
  db.each(sql, {machine}, [&](const db::Row& row) { values[row.text(0)] = row.real(1); });
  return values;
}

}  // namespace

MachineContent machine_content(db::Database& db, std::int64_t machine) {
  const auto row = db::machine(db, machine);
  if (!row) throw db::Refusal("not_found", "machine:" + std::to_string(machine));
  return {*row, db::residents(db, machine), values_of(db, machine)};
}

json write_machine(ArchiveWriter& archive, const MachineContent& content, const db::Blobs& blobs) {
  const db::MachineRow& machine = content.machine;
  json about = {{"name", machine.name},         {"profile", machine.profile},
                {"software", machine.software}, {"parts_required", machine.parts_required},
                {"last_seen", machine.last_seen_ms ? json(db::iso_time(*machine.last_seen_ms)) : json(nullptr)}};
  json programs = json::array(), not_here = json::array();
  int number = 0;
  for (const db::ResidentRow& program : content.programs) {
    if (!on_disk(blobs, program.sha256)) {
      not_here.push_back(program.name);
      continue;
    }
    // Numbered: a program's name need not be a file name.
    const std::string entry = "programs/" + std::to_string(++number);
    archive.add_file(entry, blobs.path(program.sha256), program.sha256);
    programs.push_back({{"entry", entry}, {"name", program.name}, {"sha256", program.sha256}, {"selected", program.selected}});
  }
  archive.add("machine.json", about.dump(1));
  archive.add("machine.toml", machine.toml);
  archive.add("values.json", json(content.values).dump(1));
  archive.add("programs.json", programs.dump(1));
  return {{"machine", about},
          {"values", content.values.size()},
          {"programs", programs.size()},
          {"not_here", std::move(not_here)}};
}

MachineArchive read_machine(const std::filesystem::path& file, const db::Blobs& blobs) {
  MachineArchive found;
  found.manifest = verify(file);
  if (found.manifest.value("kind", "") != "machine") throw db::Refusal("not_a_backup", found.manifest.value("kind", ""));
  const auto parsed = [](Entry& entry) {
    json value = json::parse(entry.all(), nullptr, false);
    if (value.is_discarded()) throw db::Refusal("damaged_backup", entry.name());
    return value;
  };
  json programs = json::array();
  std::map<std::string, std::string> texts;
  each_entry(file, [&](Entry& entry) {
    if (entry.name() == "machine.json") {
      const json machine = parsed(entry);
      found.name = machine.value("name", "");
      found.profile = machine.value("profile", "");
    } else if (entry.name() == "machine.toml") {
      found.toml = entry.all();
    } else if (entry.name() == "values.json") {
      const json values = parsed(entry);  // outlives the loop over it
      for (const auto& [what, value] : values.items())
        if (value.is_number()) found.values[what] = value.get<double>();
    } else if (entry.name() == "programs.json") {
      programs = parsed(entry);
    } else if (entry.name().starts_with("programs/")) {
      auto writer = blobs.begin();
      std::vector<char> piece(1u << 18);
      while (const std::size_t got = entry.read(piece.data(), piece.size())) writer.append({piece.data(), got});
      texts[entry.name()] = writer.finish();
    }
  });
  for (const json& program : programs) {
    const auto text = texts.find(program.value("entry", ""));
    if (text == texts.end() || text->second != program.value("sha256", "")) throw db::Refusal("damaged_backup", "programs.json");
    found.programs.push_back({program.value("name", ""), text->second, program.value("selected", false)});
  }
  return found;
}

}  // namespace headstock::backup
