// What the controls' manuals say about their serial ports, one row a protocol, and how a row becomes the
// rules of the state machines. What a manual does not say is said here as not said; each can be changed for a
// port.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "protocol/serial/receiver.hpp"
#include "protocol/serial/sender.hpp"
#include "protocol/serial/settings.hpp"
#include "protocol/tape/decoder.hpp"
#include "protocol/tape/encoder.hpp"

namespace headstock::serial {

struct Protocol {
  std::string_view name;    ///< "dc1-dc4"
  std::string_view en, zh;  ///< what it is, for people
  std::string_view source;  ///< of the rule
  LineSettings line;        ///< the manual's or the usual one
  tape::Code code = tape::Code::ascii;
  tape::EndOfBlock end_of_block = tape::EndOfBlock::lf;
  bool wait_for_start = false;  ///< the control asks with DC1 before anything is sent
  bool punch_codes = false;     ///< the control marks its punch with DC2 and DC4
  bool frame = true;            ///< % lines around the program
  std::optional<std::uint8_t> end_byte;
  std::uint32_t after_stop = 16;  ///< characters the control takes after its DC3
};

std::span<const Protocol> protocols();
/// @return nullptr when there is none of that name.
const Protocol* protocol_named(std::string_view name);

/// What can be set for a port besides its line; starts as the protocol's row says.
struct LinkSettings {
  std::string protocol = "dc1-dc4";
  LineSettings line;
  tape::Code code = tape::Code::iso;
  tape::Symbols symbols;
  tape::EndOfBlock end_of_block = tape::EndOfBlock::lf;
  std::uint32_t leader = 0, trailer = 0;
  bool frame = true, pad_for_tv = false, fold_case = true;
  bool tv_check = false;
  std::uint32_t after_stop = 10;
  std::uint32_t block_delay_ms = 0;
  /// 0: no limit. A drip-feed may be held for as long as the control likes, whatever `hold_limit_s` says.
  std::uint32_t start_limit_s = 600, hold_limit_s = 600;
  std::uint32_t quiet_ms = 5'000;
  std::uint32_t punch_limit_s = 14'400;    ///< a punch that takes longer does not end; 0: no limit
  std::uint64_t most_bytes = 16ull << 20;  ///< of one punch
};
/// The settings of a protocol's row; throws std::invalid_argument for an unknown name.
LinkSettings default_settings(std::string_view protocol);

/// Characters that may be under way, so that after its DC3 a control gets no more than it takes
/// (`after_stop`), two characters of margin kept. @param round_trip of one character to the far end and back,
/// as the loop-back test measures it: what a USB adapter or a serial-device server holds back counts as under
/// way. 0: not measured.
/// @return at least 1.
std::uint32_t window_of(const LinkSettings& settings, Duration round_trip = {});
/// What is left of `after_stop` behind the window and the way there and back; below 0: this line cannot be
/// stopped in time at this speed.
std::int64_t stop_margin(const LinkSettings& settings, Duration round_trip);
SendRules send_rules(const LinkSettings& settings, Duration round_trip = {});
ReceiveRules receive_rules(const LinkSettings& settings);
tape::PunchFormat punch_format(const LinkSettings& settings);
tape::ReadFormat read_format(const LinkSettings& settings);

}  // namespace headstock::serial
