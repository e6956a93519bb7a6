#include "server/library/check_setup.hpp"

#include <cctype>

namespace headstock::library {
namespace {

/// The folder's other programs, as the machine would find them in its memory.
class Neighbours final : public program::Programs {
 public:
  explicit Neighbours(const std::map<std::string, std::string>& files) : files_(files) {}

  std::unique_ptr<program::Source> open_number(std::uint32_t number) override {
    for (const auto& [name, file] : files_)
      if (number_of(name) == number) return program::source_from_file(file);
    return nullptr;
  }
  std::unique_ptr<program::Source> open_name(std::string_view name) override {
    const auto found = files_.find(std::string(name));
    return found == files_.end() ? nullptr : program::source_from_file(found->second);
  }

 private:
  /// "O1234", "o1234.nc", "1234.txt" → 1234; 0 when it is not a number.
  static std::uint32_t number_of(const std::string& name) {
    std::size_t at = !name.empty() && (name[0] == 'O' || name[0] == 'o') ? 1 : 0;
    std::uint32_t number = 0;
    std::size_t digits = 0;
    for (; at < name.size() && std::isdigit(static_cast<unsigned char>(name[at])) != 0 && digits < 9;
         ++at, ++digits)
      number = number * 10 + static_cast<std::uint32_t>(name[at] - '0');
    return digits > 0 && (at == name.size() || name[at] == '.') ? number : 0;
  }

  std::map<std::string, std::string> files_;
};

}  // namespace

std::string set_up(const CheckJob& job, Setup& setup) {
  if (job.machine.toml.empty()) {
    auto machine = machine::default_machine(job.machine.profile);
    if (!machine) return "profile " + job.machine.profile;
    setup.machine = std::move(*machine);
  } else {
    auto parsed = machine::parse_machine(job.machine.toml, job.machine.name, job.machine.profile);
    if (const auto* error = std::get_if<machine::MachineError>(&parsed)) return error->message;
    setup.machine = std::get<machine::Machine>(std::move(parsed));
  }
  std::vector<char> axes;
  for (const machine::Axis& axis : setup.machine.axes) axes.push_back(axis.name);
  if (const std::string mistake = interp::load_offsets(
          job.machine.offsets_json.empty() ? "{}" : job.machine.offsets_json, axes, setup.data);
      !mistake.empty())
    return "offsets: " + mistake;
  for (const db::OffsetRow& setting : job.settings) {
    if (setting.what.starts_with("parameter/"))
      setup.data.parameters[setting.what.substr(10)] = setting.value;
    if (setting.what.starts_with("variable/"))
      setup.data.common_variables[static_cast<std::uint32_t>(std::stoul(setting.what.substr(9)))] =
          setting.value;
  }
  setup.neighbours = std::make_shared<Neighbours>(job.subprograms);
  setup.open = [file = job.file] { return program::source_from_file(file); };
  return {};
}

}  // namespace headstock::library
