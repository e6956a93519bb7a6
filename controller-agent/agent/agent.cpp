#include "agent/agent.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "agent/dnc_input.hpp"
#include "agent/panel_manual.hpp"
#include "agent/panel_server.hpp"
#include "link/live_json.hpp"
#include "link/program_request.hpp"
#include "protocol/process/log.hpp"
#include "protocol/wire/reasons.hpp"

namespace headstock::agent {
namespace {

using nlohmann::json;
/// A server that does not answer any more does not keep a machine from being switched off.
constexpr std::chrono::milliseconds kGoodByeWithin{1'000};

std::unique_ptr<link::Spool> open_spool(const std::filesystem::path& file, bool set_aside_damaged) {
  try {
    return std::make_unique<link::Spool>(file);
  } catch (const link::SpoolDamaged& damaged) {
    if (!set_aside_damaged) {
      throw std::runtime_error(std::string(damaged.what()) +
                               "\nPart counts and events not yet sent are in it. To start with an empty one and keep "
                               "this one for rescue, start with --set-aside-damaged.");
    }
    const auto kept = link::Spool::set_aside(file);
    log::error("{}; it was set aside as {}", damaged.what(), kept.string());
    return std::make_unique<link::Spool>(file);
  }
}

/// The machine file given now is kept in the data folder, so that a restart runs the same machine.
machine::Machine read_machine(const AgentOptions& options, const DataFolder& folder) {
  const auto file = options.machine_file.empty() ? folder.machine_file() : options.machine_file;
  if (!std::filesystem::exists(file)) {
    throw std::runtime_error("there is no machine file " + file.string() +
                             ": give one with --machine FILE.toml (deploy/machines has commented ones)");
  }
  auto loaded = machine::load_machine(file);
  if (const auto* error = std::get_if<machine::MachineError>(&loaded)) throw std::runtime_error(error->message);
  const auto kept = folder.machine_file();
  const auto beside = kept.string() + ".new";
  const std::string text = machine::to_toml(std::get<machine::Machine>(loaded));
  if (!(std::ofstream(beside, std::ios::trunc) << text)) throw std::runtime_error("cannot write " + beside);
  std::filesystem::rename(beside, kept);
  return std::get<machine::Machine>(std::move(loaded));
}

json answer_json(const operation::CommandResult& result) {
  json answer = {{"accepted", result.accepted}, {"reason", result.reason}};
  if (!result.accepted) {
    const auto text = protocol::reason_text(result.reason);
    answer["text"] = {{"en", std::string(text.en)}, {"zh", std::string(text.zh)}};
  }
  return answer;
}

}  // namespace

Agent::Agent(AgentOptions options)
    : options_(std::move(options)), folder_(options_.data), machine_(read_machine(options_, folder_)) {
  spool_ = open_spool(folder_.spool(), options_.set_aside_damaged);
  memory_ = std::make_shared<link::ProgramMemory>(folder_.programs(), machine_.program_memory_bytes);
  operation::ControllerOptions controller_options;
  controller_options.retained = read_counters(*spool_);
  controller_options.switches = options_.switches;
  controller_ = std::make_unique<operation::Controller>(machine_, read_data(*spool_, machine_),
                                                        std::move(controller_options));
  store_power_on(*spool_, controller_->data(), machine_);
  desk_ = std::make_unique<DataDesk>(*controller_, *spool_);
  const SelectedProgram last = read_selected(*spool_);
  if (!last.name.empty() && select(last.name, operation::Origin::panel).accepted && selected_.sha256 != last.sha256) {
    log::warning("the selected program {} is not the same as before the restart", last.name);
  }
  memory_->in_use([this](const std::string& name) {
    const operation::Live now = controller_->live();
    return now.program_name == name && now.state != operation::State::idle && now.state != operation::State::alarm;
  });
  manual_ = std::make_unique<PanelManual>(io_, *controller_);
  panel_ = std::make_unique<PanelServer>(io_, folder_.panel_socket(),
                                         [this](const std::string& request) { return panel(request); });
  if (options_.dnc) {
    dnc_ = std::make_unique<DncInput>(
        io_.get_executor(), *options_.dnc,
        [this](std::unique_ptr<program::Source> stream, std::function<std::string()> why) {
          const auto result = controller_->select_stream("DNC", {}, std::move(stream), 0, operation::Origin::panel,
                                                         std::move(why));
          if (result.accepted) selected_ = {};
          return result;
        });
  }
  if (options_.host.empty()) return;
  link::LinkOptions link_options;
  link_options.host = options_.host;
  link_options.port = options_.port;
  link_options.pki_folder = folder_.pki();
  link_options.enrolment_token = options_.token;
  link_options.machine_name = machine_.name;
  link_options.profile = machine_.profile;
  for (const machine::Axis& axis : machine_.axes) link_options.axes.emplace_back(1, axis.name);
  link_options.machine_toml = machine::to_toml(machine_);
  link_options.drip_buffer_bytes = options_.drip_buffer_bytes;
  link_ = std::make_unique<link::Link>(io_, std::move(link_options), *this, *spool_, *memory_);
}

Agent::~Agent() = default;

void Agent::run() {
  storage_ = std::make_unique<Storage>(*controller_, *spool_);
  clock_ = std::make_unique<MachineClock>(*controller_, options_.clock);
  panel_->start();
  if (link_) link_->start();
  log::info("{} ({}), period {} us, {} axes, {} drives", machine_.name, machine_.profile, machine_.period_us,
               machine_.axes.size(), machine_.drive);
  io_.run();
  // The axes come to rest inside their limits before the clock stops.
  controller_->command({operation::Action::reset, operation::Origin::panel});
  for (int waited_ms = 0; waited_ms < 5'000 && controller_->live().state == operation::State::running; ++waited_ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (dnc_) dnc_->switch_off();
  if (link_ && link_->say_good_bye()) {
    io_.restart();
    const auto until = std::chrono::steady_clock::now() + kGoodByeWithin;
    while (link_->connection_open() && std::chrono::steady_clock::now() < until)
      io_.run_one_for(std::chrono::milliseconds(10));
  }
  if (link_) link_->stop();
  panel_.reset();
  clock_.reset();
  storage_.reset();
}

void Agent::stop() { io_.stop(); }

operation::Live Agent::live() { return controller_->live(); }
std::string Agent::selected_sha256() { return selected_.sha256; }

operation::CommandResult Agent::command(const operation::Command& command, const std::string& user) {
  operation::Command named = command;
  named.user = user;
  const auto result = controller_->command(named);
  log::info("{} from {}: {}", link::action_name(command.action), user,
               result.accepted ? "accepted" : "refused, " + result.reason);
  return result;
}

operation::CommandResult Agent::select(const std::string& name, const std::string& user) {
  const auto result = select(name, operation::Origin::network);
  log::info("select {} from {}: {}", name, user, result.accepted ? "accepted" : "refused, " + result.reason);
  return result;
}

operation::CommandResult Agent::select(const std::string& name, operation::Origin origin) {
  const auto resident = memory_->find(name);
  if (!resident) return {false, "not_found"};
  const auto result = controller_->select(resident->name, resident->sha256, memory_, origin);
  if (result.accepted) {
    if (dnc_) dnc_->switch_off();
    selected_ = {resident->name, resident->sha256};
    const link::RetainedValue value = selected_value(selected_);
    spool_->commit({}, {&value, 1});
  }
  return result;
}

operation::CommandResult Agent::open_stream(const std::string& name, const std::string& sha256,
                                            std::unique_ptr<program::Source> stream, std::uint64_t total_bytes) {
  // What a person at this machine has asked for he has seen.
  const auto origin = !requested_.empty() && link::same_program(requested_, name) ? operation::Origin::panel
                                                                                  : operation::Origin::network;
  const auto result = controller_->select_stream(name, sha256, std::move(stream), total_bytes, origin);
  if (result.accepted) {
    requested_.clear();
    if (dnc_) dnc_->switch_off();
    selected_ = {name, sha256};
  }
  return result;
}

void Agent::request_answered(const std::string& name, const operation::CommandResult& answer) {
  log::info("the server was asked for {}: {}", name, answer.accepted ? "it comes" : answer.reason);
  request_answer_ = answer.reason;
  if (!answer.accepted) requested_.clear();
}

operation::CommandResult Agent::switch_dnc(bool on) {
  if (!dnc_) return {false, "unsupported"};
  if (on) return dnc_->switch_on();
  dnc_->switch_off();
  return {true, ""};
}

void Agent::write_data(const json& request, std::function<void(json)> done) {
  desk_->write(request, std::move(done));
}
json Agent::data_report() {
  return desk_->report();
}
void Agent::events_committed() {
  desk_->committed();
}

void Agent::link_up(const link::ServerSettings& settings) {
  log::info("connected to the server as machine {}", settings.machine);
}

void Agent::link_lost(const std::string& reason) {
  controller_->link_lost();
  requested_.clear();
  log::warning("link to the server lost: {}; remote operation is no longer armed", reason);
}

std::string Agent::panel(const std::string& request) {
  const json asked = json::parse(request, nullptr, false);
  if (!asked.is_object() || !asked.value("do", json()).is_string()) return answer_json({false, "bad_request"}).dump();
  const auto verb = asked["do"].get<std::string>();
  const auto text = [&](const char* key) {
    const auto found = asked.find(key);
    return found != asked.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  if (verb == "status") {
    json state = link::live_to_json(controller_->live(), selected_.sha256);
    state["machine_name"] = machine_.name;
    state["profile"] = machine_.profile;
    state["parameter_write"] = desk_->parameter_write();
    if (link_) {
      const link::LinkStatus status = link_->status();
      state["link"] = {{"connected", status.connected}, {"detail", status.detail}, {"pending", status.events_pending}};
    } else {
      state["link"] = nullptr;
    }
    if (dnc_) {
      const DncInput::Status now = dnc_->status();
      state["dnc"] = {{"port", dnc_->settings().port}, {"state", name_of(now.state)}, {"open", now.open},
                      {"reason", now.reason},          {"received", now.received},    {"buffered", now.buffered},
                      {"last", {{"bytes", now.bytes}, {"sha256", now.sha256}, {"outcome", now.outcome}}}};
    }
    state["request"] = {{"name", requested_}, {"reason", request_answer_}};
    json resident = json::array();
    for (const auto& program : memory_->census()) resident.push_back({{"name", program.name}, {"bytes", program.bytes}});
    state["programs"] = std::move(resident);
    return state.dump();
  }
  if (verb == "select") return answer_json(select(text("name"), operation::Origin::panel)).dump();
  if (verb == "set_value" || verb == "measured_value") {
    const auto result = desk_->write_here(text("name"), verb == "set_value" ? "panel" : "measurement");
    log::info("{} at the panel: {}", text("name"), result.accepted ? "written" : "refused, " + result.reason);
    return answer_json({result.accepted, result.reason}).dump();
  }
  if (verb == "touch") {
    const auto result = desk_->touch_here(text("name"));
    log::info("{} touched at the panel: {}", text("name"), result.accepted ? "written" : "refused, " + result.reason);
    return answer_json({result.accepted, result.reason}).dump();
  }
  if (verb == "get_value") {
    const auto value = desk_->value_here(text("name"));
    if (!value) return answer_json({false, "bad_place"}).dump();
    return json{{"accepted", true}, {"reason", ""}, {"value", *value ? json(**value) : json(nullptr)}}.dump();
  }
  if (verb == "parameter_write") {
    const auto result = desk_->parameter_write(asked.value("value", json(0)) != json(0));
    log::warning("parameters may be written: {}", desk_->parameter_write());
    return answer_json(result).dump();
  }
  if (verb == "load") {
    const std::string file = text("file");
    std::ifstream in(file, std::ios::binary);
    if (!in) return answer_json({false, "not_found"}).dump();
    std::ostringstream content;
    content << in.rdbuf();
    const auto put = memory_->put(std::filesystem::path(file).filename().string(), content.str());
    return answer_json({put.ok(), put.reason}).dump();
  }
  if (const auto by_hand = manual_->carry_out(verb, asked)) {
    if (verb != "jog" || !by_hand->accepted)
      log::info("{} at the panel: {}", request, by_hand->accepted ? "accepted" : "refused, " + by_hand->reason);
    return answer_json(*by_hand).dump();
  }
  if (verb == "request") {
    requested_ = text("name");
    request_answer_.clear();
    if (requested_.empty() || !link_ || !link_->request(requested_)) {
      requested_.clear();
      return answer_json({false, "not_connected"}).dump();
    }
    return answer_json({true, ""}).dump();
  }
  if (verb == "dnc_input") {
    const bool on = asked.contains("value") && asked["value"].is_number() && asked["value"].get<double>() != 0;
    const auto switched = switch_dnc(on);
    log::info("DNC input {} at the panel: {}", on ? "on" : "off", switched.accepted ? "done" : switched.reason);
    return answer_json(switched).dump();
  }
  operation::Action action{};
  if (!link::action_from_name(verb, action)) return answer_json({false, "unknown_command"}).dump();
  const double value = asked.contains("value") && asked["value"].is_number() ? asked["value"].get<double>() : 0;
  const auto result = controller_->command({action, operation::Origin::panel, value});
  log::info("{} at the panel: {}", verb, result.accepted ? "accepted" : "refused, " + result.reason);
  return answer_json(result).dump();
}

}  // namespace headstock::agent
