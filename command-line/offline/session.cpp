#include "offline/session.hpp"

#include <cstdio>
#include <fstream>
#include <iterator>

#include "protocol/process/options.hpp"

namespace headstock::offline {
namespace {

std::optional<std::string> read_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(in), {});
}

bool truth(std::string_view value, bool& out) {
  if (value == "true" || value == "1" || value == "on") return out = true, true;
  if (value == "false" || value == "0" || value == "off") return out = false, true;
  return false;
}

// gcode_system=A lenient=true decimal_point=pocket optional_stop=on block_skip=1,3
bool apply_setting(std::string_view setting, interp::Switches& switches) {
  const auto equals = setting.find('=');
  if (equals == setting.npos) return false;
  const std::string_view key = setting.substr(0, equals);
  const std::string_view value = setting.substr(equals + 1);
  if (key == "gcode_system") {
    if (value != "A" && value != "B" && value != "C") return false;
    switches.gcode_system = value[0];
    return true;
  }
  if (key == "lenient") return truth(value, switches.lenient);
  if (key == "optional_stop") return truth(value, switches.optional_stop);
  if (key == "decimal_point") {
    if (value != "standard" && value != "pocket") return false;
    switches.decimal_point =
        value == "pocket" ? interp::DecimalPoint::pocket : interp::DecimalPoint::standard;
    return true;
  }
  if (key == "block_skip") {
    bool all = false;
    if (value.size() > 1 && truth(value, all)) {
      switches.block_skip = all ? 0x3feu : 0;
      return true;
    }
    for (const char c : value) {
      if (c == ',') continue;
      if (c < '0' || c > '9') return false;
      if (c != '0') switches.block_skip |= 1u << (c - '0');
    }
    return true;
  }
  return false;
}

class StandardInput final : public program::Source {
 public:
  program::ReadResult read(std::span<char> buffer) override {
    const std::size_t bytes = std::fread(buffer.data(), 1, buffer.size(), stdin);
    if (bytes > 0) return {program::ReadStatus::data, bytes};
    return {std::ferror(stdin) != 0 ? program::ReadStatus::failed : program::ReadStatus::end, 0};
  }
  bool seek(std::uint64_t) override { return false; }
};

}  // namespace

void add_options(options::Command command, Options& options) {
  command.option("--profile", options.profile,
                 "Controller: fanuc-0i-t, fanuc-0i-m, gsk-2000tc, gsk-218t, k2000tc, lathe-200t");
  command.option("--machine", options.machine_file, "Machine file (TOML)");
  command.option("--offsets", options.offsets_file, "Work and tool offsets (JSON)");
  command.option("--params", options.params_file, "Parameters by the manual's number (JSON)");
  command.option(
      "--set", options.settings,
      "gcode_system=A|B|C, lenient=true, decimal_point=standard|pocket, optional_stop=true, block_skip=1,3");
  command.option("--lib", options.libraries, "Folder of sub-programs");
}

std::vector<char> Session::axis_names() const {
  std::vector<char> names;
  for (const auto& axis : machine.axes) names.push_back(axis.name);
  return names;
}

machine::AxisVector Session::start_position() const {
  machine::AxisVector position{};
  for (std::size_t i = 0; i < machine.axes.size(); ++i) position[i] = machine.axes[i].reference_mm;
  return position;
}

std::unique_ptr<Session> make_session(const Options& options, std::string& error) {
  auto session = std::make_unique<Session>();
  std::string profile = options.profile;
  if (!options.machine_file.empty()) {
    auto loaded = machine::load_machine(options.machine_file, profile);
    if (const auto* wrong = std::get_if<machine::MachineError>(&loaded)) {
      error = wrong->message;
      return nullptr;
    }
    session->machine = std::get<machine::Machine>(std::move(loaded));
    profile = session->machine.profile;
  } else if (profile.empty()) {
    error = "--profile or --machine is needed";
    return nullptr;
  } else if (auto standard = machine::default_machine(profile)) {
    session->machine = *std::move(standard);
  }
  session->dialect = dialects::find(profile);
  if (session->dialect == nullptr) {
    error = "unknown profile: " + profile;
    return nullptr;
  }
  const auto load = [&](const std::string& path, const auto& into) {
    if (path.empty()) return true;
    const auto text = read_file(path);
    const std::string wrong = text ? into(*text) : "cannot be read";
    if (!wrong.empty()) error = path + ": " + wrong;
    return wrong.empty();
  };
  if (!load(options.offsets_file, [&](const std::string& text) {
        return interp::load_offsets(text, session->axis_names(), session->data);
      })) {
    return nullptr;
  }
  if (!load(options.params_file,
            [&](const std::string& text) { return interp::load_parameters(text, session->data); })) {
    return nullptr;
  }
  for (const std::string& setting : options.settings) {
    if (!apply_setting(setting, session->switches)) {
      error = "--set " + setting + ": unknown setting or value";
      return nullptr;
    }
  }
  for (const std::string& folder : options.libraries) session->programs.add_folder(folder);
  return session;
}

std::unique_ptr<program::Source> open_program(const std::string& file) {
  if (file == "-") return std::make_unique<StandardInput>();
  return program::source_from_file(file);
}

}  // namespace headstock::offline
