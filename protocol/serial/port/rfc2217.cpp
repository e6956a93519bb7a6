#include "protocol/serial/port/rfc2217.hpp"

namespace headstock::serial {
namespace {

enum : std::uint8_t { se = 240, sb = 250, will = 251, wont = 252, do_it = 253, dont = 254, iac_byte = 255 };
enum : std::uint8_t { binary = 0, suppress_go_ahead = 3, com_port = 44 };
enum : std::uint8_t {
  set_baud = 1,
  set_data_size = 2,
  set_parity = 3,
  set_stop_size = 4,
  set_control = 5,
  flow_suspend = 8,
  flow_resume = 9,
  set_line_mask = 10,
  set_modem_mask = 11,
  purge_data = 12,
  server_offset = 100,
  notify_line = 106,
  notify_modem = 107
};
enum : std::uint8_t { no_flow = 1, hardware_flow = 3, dtr_on = 8, dtr_off = 9, rts_on = 11, rts_off = 12 };
constexpr std::uint8_t kPurgeOutput = 2;
// Line state: overrun 2, parity 4, framing 8, break 16. Modem state: CTS 16, DSR 32, ring 64, carrier 128.
constexpr std::uint8_t kLineMask = 2 | 4 | 8 | 16, kModemMask = 0xFF;
constexpr std::size_t kLongestSub = 256;

void add(std::string& text, std::uint8_t byte) {
  text += static_cast<char>(byte);
  if (byte == iac_byte) text += static_cast<char>(byte);
}

std::string option(std::uint8_t setting, std::initializer_list<std::uint8_t> values) {
  std::string text;
  for (const std::uint8_t byte : {std::uint8_t{iac_byte}, std::uint8_t{sb}, std::uint8_t{com_port}, setting})
    text += static_cast<char>(byte);
  for (const std::uint8_t value : values) add(text, value);
  text += static_cast<char>(iac_byte);
  text += static_cast<char>(se);
  return text;
}

std::uint8_t parity_value(Parity parity) {
  switch (parity) {
    case Parity::none:
      return 1;
    case Parity::odd:
      return 2;
    case Parity::even:
      return 3;
    case Parity::mark:
      return 4;
    case Parity::space:
      return 5;
  }
  return 1;
}

std::string negotiate(std::uint8_t verb, std::uint8_t what) {
  return {static_cast<char>(iac_byte), static_cast<char>(verb), static_cast<char>(what)};
}

std::uint32_t number_of(std::string_view bytes) {
  std::uint32_t number = 0;
  for (const char byte : bytes) number = number << 8 | static_cast<std::uint8_t>(byte);
  return number;
}

}  // namespace

std::string Rfc2217::hello() {
  return negotiate(will, com_port) + negotiate(will, binary) + negotiate(do_it, binary) +
         negotiate(will, suppress_go_ahead) + negotiate(do_it, suppress_go_ahead);
}

std::string Rfc2217::escaped(std::string_view data) {
  std::string text;
  text.reserve(data.size() + 8);
  for (const char byte : data) add(text, static_cast<std::uint8_t>(byte));
  return text;
}

std::string Rfc2217::ask_settings() const {
  const auto byte = [&](unsigned shift) { return static_cast<std::uint8_t>(settings_.baud >> shift); };
  std::string text = option(set_baud, {byte(24), byte(16), byte(8), byte(0)});
  text += option(set_data_size, {settings_.data_bits});
  text += option(set_parity, {parity_value(settings_.parity)});
  text += option(set_stop_size, {settings_.stop_bits});
  // DC1 and DC3 are ours to see; CTS is the server's, which reacts at once.
  text += option(set_control, {settings_.hardware() ? std::uint8_t{hardware_flow} : std::uint8_t{no_flow}});
  text += option(set_line_mask, {kLineMask});
  text += option(set_modem_mask, {kModemMask});
  return text + set_dtr(true) + (settings_.hardware() ? std::string() : set_rts(true));
}

std::string Rfc2217::set_rts(bool on) const {
  return option(set_control, {on ? std::uint8_t{rts_on} : std::uint8_t{rts_off}});
}
std::string Rfc2217::set_dtr(bool on) const {
  return option(set_control, {on ? std::uint8_t{dtr_on} : std::uint8_t{dtr_off}});
}
std::string Rfc2217::discard_output() const {
  return option(purge_data, {kPurgeOutput});
}

void Rfc2217::command(std::uint8_t verb, std::uint8_t what, Events& events, std::string& answer) {
  if (what == com_port) {
    if (verb == do_it && !asked_) {
      asked_ = true;
      answer += ask_settings();
    }
    if (verb == dont) events.refused = "no_rfc2217";
    return;
  }
  if (what == binary || what == suppress_go_ahead) return;  // what we asked for, or agree to
  if (verb == will) answer += negotiate(dont, what);
  if (verb == do_it) answer += negotiate(wont, what);
}

void Rfc2217::confirmed(std::uint8_t setting, Events& events) {
  constexpr unsigned all = 1u << set_baud | 1u << set_data_size | 1u << set_parity | 1u << set_stop_size;
  confirmed_ |= 1u << setting;
  if (ready_ || (confirmed_ & all) != all) return;
  ready_ = events.ready = true;
}

void Rfc2217::subnegotiation(Events& events, std::string&) {
  if (sub_.size() < 2 || static_cast<std::uint8_t>(sub_[0]) != com_port) return;
  const auto code = static_cast<std::uint8_t>(sub_[1]);
  const auto values = std::string_view(sub_).substr(2);
  const auto value = values.empty() ? std::uint8_t{0} : static_cast<std::uint8_t>(values.back());
  const auto check = [&](std::uint8_t setting, bool same, const char* reason) {
    if (!same) events.refused = reason;
    confirmed(setting, events);
  };
  switch (code) {
    case server_offset + set_baud:
      return check(set_baud, number_of(values) == settings_.baud, "bad_baud");
    case server_offset + set_data_size:
      return check(set_data_size, value == settings_.data_bits, "bad_data_bits");
    case server_offset + set_parity:
      return check(set_parity, value == parity_value(settings_.parity), "bad_parity");
    case server_offset + set_stop_size:
      return check(set_stop_size, value == settings_.stop_bits, "bad_stop_bits");
    case server_offset + set_control:
      if (value == dtr_on || value == dtr_off) signals_.dtr = value == dtr_on;
      if (value == rts_on || value == rts_off) signals_.rts = value == rts_on;
      events.signals_changed = true;
      return;
    case notify_line:
      if (value & 2) events.faults.push_back(Fault::overrun);
      if (value & 4) events.faults.push_back(Fault::parity);
      if (value & 8) events.faults.push_back(Fault::framing);
      if (value & 16) events.faults.push_back(Fault::line_break);
      return;
    case notify_modem:
      signals_.known = true;
      signals_.cts = value & 16;
      signals_.dsr = value & 32;
      signals_.ring = value & 64;
      signals_.dcd = value & 128;
      events.signals_changed = true;
      return;
    case flow_suspend:
    case server_offset + flow_suspend:
      suspended_ = true;
      return;
    case flow_resume:
    case server_offset + flow_resume:
      suspended_ = false;
      return;
    default:
      return;
  }
}

Rfc2217::Events Rfc2217::put(std::string_view bytes, std::string& answer) {
  Events events;
  for (const char byte : bytes) {
    const auto value = static_cast<std::uint8_t>(byte);
    switch (state_) {
      case At::data:
        if (value == iac_byte) {
          state_ = At::iac;
        } else {
          events.data += byte;
        }
        break;
      case At::iac:
        state_ = At::data;
        if (value == iac_byte) {
          events.data += byte;
        } else if (value >= will && value <= dont) {
          verb_ = value;
          state_ = At::verb;
        } else if (value == sb) {
          sub_.clear();
          state_ = At::sub;
        }
        break;
      case At::verb:
        state_ = At::data;
        command(verb_, value, events, answer);
        break;
      case At::sub:
        if (value == iac_byte) {
          state_ = At::sub_iac;
        } else if (sub_.size() < kLongestSub) {
          sub_ += byte;
        }
        break;
      case At::sub_iac:
        if (value == iac_byte) {
          if (sub_.size() < kLongestSub) sub_ += byte;
          state_ = At::sub;
        } else {
          if (value == se) subnegotiation(events, answer);
          state_ = At::data;
        }
        break;
    }
  }
  return events;
}

}  // namespace headstock::serial
