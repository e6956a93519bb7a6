#include "protocol/serial/protocols.hpp"

#include <algorithm>
#include <stdexcept>

namespace headstock::serial {
namespace {

using tape::Code;
using tape::EndOfBlock;

constexpr LineSettings line(std::uint32_t baud, std::uint8_t bits, Parity parity, std::uint8_t stops,
                            Handshake handshake) {
  return {baud, bits, parity, stops, handshake};
}

constexpr Protocol kProtocols[] = {
    {"plain",
     "Bytes one after the other, no handshake",
     "无握手，逐字节传送",
     "",
     line(9'600, 8, Parity::none, 1, Handshake::none),
     Code::ascii,
     EndOfBlock::cr_lf,
     false,
     false,
     true,
     {},
     16},
    {"xon-xoff",
     "Sends at once; DC3 stops, DC1 goes on",
     "立即发送；DC3 停，DC1 继续",
     "",
     line(9'600, 8, Parity::none, 1, Handshake::software),
     Code::ascii,
     EndOfBlock::lf,
     false,
     true,
     true,
     {},
     16},
    {"dc1-dc4",
     "FANUC reader/punch: the control starts with DC1, stops with DC3, punches between DC2 and DC4",
     "FANUC 阅读机/穿孔机：机床以 DC1 启动、DC3 停止，DC2 与 DC4 之间穿孔",
     "B-64304CM L20047, L20207, PS0087; No.0100#3",
     line(9'600, 8, Parity::none, 2, Handshake::software),
     Code::iso,
     EndOfBlock::lf,
     true,
     true,
     true,
     {},
     10},
    {"rts-cts",
     "Stopped and continued by the CTS line",
     "由 CTS 线控制停止与继续",
     "",
     line(9'600, 8, Parity::none, 1, Handshake::hardware),
     Code::ascii,
     EndOfBlock::lf,
     false,
     true,
     true,
     {},
     16},
    {"lathe-200t",
     "200T/300T: 9600-8-odd-1, XON/XOFF, 1A at the end; a new name receives, a known name sends",
     "200T/300T：9600-8-奇-1，XON/XOFF，以 1AH 结束；新文件名为接收，已有文件名为发送",
     "200T L5610-L5853, L9921", line(9'600, 8, Parity::odd, 1, Handshake::software), Code::ascii,
     EndOfBlock::cr_lf, false, false, false, tape::end_of_file, 16},
    {"gsk-218t",
     "GSK218T: 9600 (P095); frame, handshake and the maker's program protocol are not in the manual",
     "GSK218T：9600（P095）；帧格式、握手与厂家通信软件协议手册未给出",
     "GSK218T L5627, L7523",
     line(9'600, 8, Parity::none, 1, Handshake::software),
     Code::ascii,
     EndOfBlock::cr_lf,
     false,
     false,
     true,
     {},
     16},
    {"gsk-2000tc",
     "2000TC: 115200 (P044), ends with %; frame and handshake are not in the manual",
     "2000TC：115200（P044），以 % 结束；帧格式与握手手册未给出",
     "2000TC L12834, L6982",
     line(115'200, 8, Parity::none, 1, Handshake::software),
     Code::ascii,
     EndOfBlock::cr_lf,
     false,
     false,
     true,
     {},
     64},
    {"k2000tc",
     "K2000TC: the manual names RS-232 and DNC, no speed, frame or protocol",
     "K2000TC：手册只列出 RS-232 与 DNC，未给出波特率、帧格式与协议",
     "K2000TC L252, L407-L419",
     line(115'200, 8, Parity::none, 1, Handshake::software),
     Code::ascii,
     EndOfBlock::cr_lf,
     false,
     false,
     true,
     {},
     64},
};

/// Two characters of the control's margin stay: one may be half on the wire when its DC3 comes, one behind
/// it.
constexpr std::uint32_t kMargin = 2;

std::uint8_t byte_of(const LinkSettings& settings, char character) {
  return tape::CharacterSet(settings.code, settings.symbols).byte_of(character).value_or(0);
}

}  // namespace

std::span<const Protocol> protocols() {
  return kProtocols;
}

const Protocol* protocol_named(std::string_view name) {
  const auto* const found = std::find_if(std::begin(kProtocols), std::end(kProtocols),
                                         [&](const Protocol& row) { return row.name == name; });
  return found == std::end(kProtocols) ? nullptr : found;
}

LinkSettings default_settings(std::string_view protocol) {
  const Protocol* const row = protocol_named(protocol);
  if (row == nullptr) throw std::invalid_argument("no protocol " + std::string(protocol));
  LinkSettings settings;
  settings.protocol = row->name;
  settings.line = row->line;
  settings.code = row->code;
  settings.end_of_block = row->end_of_block;
  settings.frame = row->frame;
  settings.fold_case = row->code != Code::ascii;
  settings.after_stop = row->after_stop;
  return settings;
}

namespace {

/// Characters that a line sends while one goes there and back, beyond the one itself.
std::int64_t on_the_way(const LinkSettings& settings, Duration round_trip) {
  const auto character = std::chrono::duration_cast<Duration>(settings.line.character_time());
  const Duration delay = round_trip - character;
  if (delay <= Duration::zero()) return 0;
  return (delay.count() + character.count() - 1) / character.count();
}

}  // namespace

std::uint32_t window_of(const LinkSettings& settings, Duration round_trip) {
  const std::int64_t room = std::int64_t{settings.after_stop} - kMargin - on_the_way(settings, round_trip);
  return static_cast<std::uint32_t>(std::max<std::int64_t>(room, 1));
}

std::int64_t stop_margin(const LinkSettings& settings, Duration round_trip) {
  return std::int64_t{settings.after_stop} - window_of(settings, round_trip) -
         on_the_way(settings, round_trip);
}

SendRules send_rules(const LinkSettings& settings, Duration round_trip) {
  const Protocol* const row = protocol_named(settings.protocol);
  SendRules rules;
  rules.wait_for_start = row != nullptr && row->wait_for_start;
  rules.obey_dc = settings.line.software();
  rules.obey_cts = settings.line.hardware();
  rules.character = std::chrono::duration_cast<Duration>(settings.line.character_time());
  rules.percent = byte_of(settings, '%');
  rules.window = window_of(settings, round_trip);
  if (row != nullptr && row->end_byte) rules.ending.assign(1, static_cast<char>(*row->end_byte));
  rules.start_limit = std::chrono::seconds(settings.start_limit_s);
  rules.hold_limit = std::chrono::seconds(settings.hold_limit_s);
  rules.block_delay = std::chrono::milliseconds(settings.block_delay_ms);
  return rules;
}

ReceiveRules receive_rules(const LinkSettings& settings) {
  const Protocol* const row = protocol_named(settings.protocol);
  ReceiveRules rules;
  rules.punch_codes = row != nullptr && row->punch_codes;
  rules.iso = settings.code != Code::ascii;
  if (row != nullptr) rules.end_byte = row->end_byte;
  rules.obey_percent = settings.frame;
  rules.percent = byte_of(settings, '%');
  rules.end_of_block = byte_of(settings, settings.end_of_block == EndOfBlock::cr ? '\r' : '\n');
  rules.quiet = std::chrono::milliseconds(settings.quiet_ms);
  rules.start_limit = std::chrono::seconds(settings.start_limit_s);
  rules.total_limit = std::chrono::seconds(settings.punch_limit_s);
  rules.most_bytes = settings.most_bytes;
  rules.software_handshake = settings.line.software();
  return rules;
}

tape::PunchFormat punch_format(const LinkSettings& settings) {
  tape::PunchFormat format;
  format.code = settings.code;
  format.symbols = settings.symbols;
  format.end_of_block = settings.end_of_block;
  format.leader = settings.leader;
  format.trailer = settings.trailer;
  format.frame = settings.frame;
  format.pad_for_tv = settings.pad_for_tv;
  format.fold_case = settings.fold_case;
  return format;
}

tape::ReadFormat read_format(const LinkSettings& settings) {
  tape::ReadFormat format;
  format.code = settings.code;
  format.symbols = settings.symbols;
  format.tv_check = settings.tv_check;
  return format;
}

}  // namespace headstock::serial
