#include "agent/panel_client.hpp"

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/read_until.hpp>
#include <boost/asio/streambuf.hpp>
#include <boost/asio/write.hpp>
#include <charconv>
#include <chrono>
#include <cmath>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <thread>

#include "agent/data_folder.hpp"
#include "agent/panel_manual.hpp"

namespace headstock::agent {
namespace {

using nlohmann::json;

enum class Takes { nothing, percent, on_off, number, mode, name, file, axis, axis_distance, axis_seconds, distance, text, axes, place };
struct Verb {
  std::string_view word;
  std::string_view action;
  Takes takes;
  std::string_view help;
};
constexpr Verb kVerbs[] = {
    {"status", "status", Takes::nothing, "the machine's state as JSON"},
    {"arm", "arm_remote", Takes::nothing, "permit remote operation until disarmed, link lost or restart"},
    {"disarm", "disarm_remote", Takes::nothing, "end remote operation"},
    {"start", "cycle_start", Takes::nothing, "cycle start"},
    {"hold", "feed_hold", Takes::nothing, "feed hold"},
    {"reset", "reset", Takes::nothing, "reset: stop, leave the program, clear alarms"},
    {"estop", "emergency_stop", Takes::nothing, "emergency stop (besides the hard-wired one)"},
    {"release", "emergency_stop_release", Takes::nothing, "release the emergency stop"},
    {"select", "select", Takes::name, "choose the program that cycle start runs"},
    {"load", "load", Takes::file, "copy a program file into the machine's memory"},
    {"request", "request", Takes::name, "ask the server to feed this program (DNC mode); its answer is in status"},
    {"dnc", "dnc_input", Takes::on_off, "take the program from the machine's own DNC line (--dnc)"},
    {"mode", "set_mode", Takes::mode, "edit, memory, mdi, jog, handle, reference or remote"},
    {"feed", "set_feed_override", Takes::percent, "feed override in percent"},
    {"rapid", "set_rapid_override", Takes::percent, "rapid override in percent"},
    {"spindle", "set_spindle_override", Takes::percent, "spindle override in percent"},
    {"single-block", "set_single_block", Takes::on_off, "on or off"},
    {"optional-stop", "set_optional_stop", Takes::on_off, "on or off"},
    {"block-skip", "set_block_skip", Takes::on_off, "on or off"},
    {"dry-run", "set_dry_run", Takes::on_off, "on or off"},
    {"machine-lock", "set_machine_lock", Takes::on_off, "on or off"},
    {"axis-lock", "axis_lock", Takes::axes, "axes whose drives keep their place (\"Z\"), or none"},
    {"manual-absolute", "set_manual_absolute", Takes::on_off, "off: what a hand moves in a held program displaces its rest"},
    {"jog", "jog", Takes::axis_seconds, "X+2.5: moves X in this direction for 2.5 s; Ctrl-C stops"},
    {"jog-rapid", "jog", Takes::axis_seconds, "the same at the rapid rate"},
    {"step", "step", Takes::axis_distance, "X-0.1: moves X by so many mm or degrees"},
    {"reference", "reference", Takes::axis, "X: to its reference point"},
    {"retrace", "retrace", Takes::distance, "back12.5 or on12.5: along the path of a held program (handle mode)"},
    {"mdi", "mdi", Takes::text, "\"G00 X10.\": the block that start carries out once"},
    {"restart", "restart", Takes::place,
     "N100, N100/3 (third time), B57 (block) or broken (where the last run ended): stops there without motion, "
     "status says what start needs"},
    {"interruption", "interruption", Takes::on_off, "the interruption signal of M96"},
    {"tap-retract", "tap_retract", Takes::nothing, "pulls a tap out that was stopped in its hole"},
    {"required", "set_parts_required", Takes::number, "parts required"},
    {"value", "get_value", Takes::name, "show an offset, parameter or variable: tool/3/wear/X"},
    {"set", "set_value", Takes::name, "write an offset, parameter or variable: tool/3/wear/X=0.02, tool/3/wear/X+=0.01"},
    {"measured", "measured_value", Takes::name, "the same as a measured value: tool/3/geometry/X=-112.4"},
    {"touch", "touch", Takes::name, "the tool touches a place: tool/3/geometry/X=42.5, work/G54/Z=0"},
    {"parameter-write", "parameter_write", Takes::on_off, "on: parameters may be written (here and from the server); an alarm until it is off and reset"},
    {"clear-parts", "reset_parts", Takes::nothing, "part count to zero (the total stays)"},
};
constexpr std::string_view kModes[] = {"edit", "memory", "mdi", "jog", "handle", "reference", "remote"};

std::optional<double> number(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Adds the argument to the request; @return false when it is not what the verb takes.
bool add_argument(const Verb& verb, const std::string& word, json& request) {
  switch (verb.takes) {
    case Takes::nothing:
      return false;
    case Takes::percent:
    case Takes::number: {
      const auto value = number(word);
      if (!value) return false;
      request["value"] = verb.takes == Takes::percent ? *value / 100 : *value;
      return true;
    }
    case Takes::on_off:
      if (word != "on" && word != "off") return false;
      request["value"] = word == "on" ? 1 : 0;
      return true;
    case Takes::mode: {
      const auto* mode = std::find(std::begin(kModes), std::end(kModes), word);
      if (mode == std::end(kModes)) return false;
      request["value"] = mode - std::begin(kModes);
      return true;
    }
    case Takes::name:
      request["name"] = word;
      return true;
    case Takes::file:
      request["file"] = std::filesystem::absolute(word).string();
      return true;
    case Takes::axis:
      request["axis"] = word;
      return true;
    case Takes::axes:
      request["axes"] = word == "none" ? std::string() : word;
      return true;
    case Takes::text:
      request["block"] = word;
      return true;
    case Takes::place: {
      if (word == "broken") return true;
      const auto slash = word.find('/');
      const auto value = word.empty() ? std::nullopt : number(word.substr(1, slash == std::string::npos ? slash : slash - 1));
      if (!value || (word[0] != 'N' && word[0] != 'B')) return false;
      request[word[0] == 'N' ? "sequence" : "block"] = *value;
      if (slash == std::string::npos) return true;
      const auto times = number(word.substr(slash + 1));
      if (!times || word[0] != 'N') return false;
      request["occurrence"] = *times;
      return true;
    }
    case Takes::distance: {
      const bool back = word.starts_with("back");
      if (!back && !word.starts_with("on")) return false;
      const auto value = number(word.substr(back ? 4 : 2));
      if (!value || *value < 0) return false;
      request["distance"] = back ? -*value : *value;
      return true;
    }
    case Takes::axis_distance:
    case Takes::axis_seconds: {
      const bool plus = word.size() > 2 && word[1] == '+';
      const auto value = word.empty() ? std::nullopt : number(word.substr(plus ? 2 : 1));
      if (!value) return false;
      request["axis"] = word.substr(0, 1);
      if (verb.takes == Takes::axis_distance) {
        request["distance"] = *value;
        return true;
      }
      request["direction"] = *value < 0 ? -1 : 1;
      request["seconds"] = std::abs(*value);
      request["rapid"] = verb.word == "jog-rapid";
      return true;
    }
  }
  return false;
}

json ask(const std::filesystem::path& folder, const json& request) {
  namespace asio = boost::asio;
  asio::io_context io;
  asio::local::stream_protocol::socket socket(io);
  socket.connect(asio::local::stream_protocol::endpoint(DataFolder::panel_socket(folder).string()));
  asio::write(socket, asio::buffer(request.dump() + "\n"));
  asio::streambuf input;
  asio::read_until(socket, input, '\n');
  return json::parse(asio::buffers_begin(input.data()), asio::buffers_end(input.data()), nullptr, false);
}

/// Holds the button down: the agent stops the axis as soon as it is not asked again.
json hold_down(const std::filesystem::path& folder, json request) {
  using clock = std::chrono::steady_clock;
  const auto until = clock::now() + std::chrono::duration<double>(request["seconds"].get<double>());
  json answer = ask(folder, request);
  while (answer.value("accepted", false) && clock::now() < until) {
    std::this_thread::sleep_for(kJogAlive / 3);
    answer = ask(folder, request);
  }
  if (!answer.value("accepted", false)) return answer;
  request["direction"] = 0;
  return ask(folder, request);
}

bool chinese() {
  const char* language = std::getenv("LANG");
  return language && std::string_view(language).substr(0, 2) == "zh";
}

}  // namespace

std::string panel_help() {
  std::string text = "Panel commands:\n";
  for (const Verb& verb : kVerbs) {
    text += "  " + std::string(verb.word) + std::string(16 - verb.word.size(), ' ') + std::string(verb.help) + "\n";
  }
  return text;
}

int run_panel(const std::filesystem::path& folder, const std::vector<std::string>& words) {
  const auto* verb = words.empty() ? std::end(kVerbs)
                                   : std::find_if(std::begin(kVerbs), std::end(kVerbs),
                                                  [&](const Verb& v) { return v.word == words[0]; });
  if (verb == std::end(kVerbs)) {
    std::cerr << "headstock-agent panel: which button?\n" << panel_help();
    return 1;
  }
  json request = {{"do", verb->action}};
  const bool wants_argument = verb->takes != Takes::nothing;
  if (words.size() != (wants_argument ? 2u : 1u) || (wants_argument && !add_argument(*verb, words[1], request))) {
    std::cerr << "headstock-agent panel " << verb->word << ": " << verb->help << "\n";
    return 1;
  }
  json answer;
  try {
    answer = verb->takes == Takes::axis_seconds ? hold_down(folder, request) : ask(folder, request);
  } catch (const boost::system::system_error& error) {
    std::cerr << "headstock-agent panel: no agent answers in " << folder.string() << " (" << error.code().message()
              << ")\n";
    return 1;
  }
  if (verb->action == "status") {
    std::cout << answer.dump(2) << "\n";
    return 0;
  }
  if (answer.value("accepted", false)) {
    if (answer.contains("value")) std::cout << answer["value"].dump() << "\n";
    return 0;
  }
  const std::string reason = answer.value("reason", "");
  const json text = answer.value("text", json::object());
  std::cerr << "refused: " << text.value(chinese() ? "zh" : "en", reason) << "\n";
  return 2;
}

}  // namespace headstock::agent
