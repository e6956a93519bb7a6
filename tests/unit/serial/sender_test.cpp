// The sender against a control and a wire of its own time: no port, no clock.
#include "protocol/serial/sender.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <optional>
#include <random>

#include "protocol/serial/protocols.hpp"
#include "protocol/tape/code.hpp"

namespace headstock::serial {
namespace {

using namespace std::chrono_literals;
using State = Sender::State;

Time at(Duration time) {
  return Time(1h + time);
}

SendRules rules_for(const char* protocol) {
  return send_rules(default_settings(protocol));
}

std::string everything(Sender& sender, Time now) {
  std::string all;
  for (auto bytes = sender.peek(now, 0); !bytes.empty(); bytes = sender.peek(now, 0)) {
    all += bytes;
    sender.wrote(bytes.size(), now);
  }
  return all;
}

TEST(Sender, WaitsForDc1) {
  Sender sender(rules_for("dc1-dc4"), text_source("ABC"), at(0s));
  EXPECT_EQ(sender.state(), State::waiting);
  EXPECT_EQ(everything(sender, at(1s)), "");
  sender.on_bytes("\x11", at(1s));
  EXPECT_EQ(everything(sender, at(1s)), "ABC");
  EXPECT_EQ(sender.state(), State::draining);
  sender.tick(at(1s), 3);
  EXPECT_EQ(sender.state(), State::draining) << "not done while the device still has characters";
  sender.tick(at(2s), 0);
  EXPECT_EQ(sender.state(), State::done);
}

TEST(Sender, KeepsWhatTheControlSaysBehindTheLastBlock) {
  Sender sender(rules_for("dc1-dc4"), text_source("ABC"), at(0s));
  sender.on_bytes("\x11", at(1s));
  sender.on_bytes("?", at(1s));
  everything(sender, at(1s));
  sender.on_bytes("\x13\x12%", at(1s));
  sender.on_bytes("\nO1", at(1s));
  sender.tick(at(2s), 0);
  EXPECT_EQ(sender.state(), State::done);
  EXPECT_EQ(sender.early(), "\x12%\nO1");
  EXPECT_EQ(sender.counters().unexpected, 1u) << "what came while we sent is no punch";
}

// A control has read the % and says DC3 before we have looked whether there is more.
TEST(Sender, ADc3RightBehindTheLastCharacterHoldsNothingBack) {
  for (const std::size_t length : {3u, 4'096u, 16'384u, 20'000u}) {
    auto rules = rules_for("dc1-dc4");
    rules.window = 30'000;
    Sender sender(rules, text_source(std::string(length, 'X')), at(0s));
    sender.on_bytes("\x11", at(1s));
    std::size_t sent = 0;
    while (sent < length) {
      const auto bytes = sender.peek(at(1s), 0);
      ASSERT_FALSE(bytes.empty());
      sent += bytes.size();
      sender.wrote(bytes.size(), at(1s));
    }
    sender.on_bytes("\x13", at(1s));
    sender.tick(at(60s), 0);
    EXPECT_EQ(sender.state(), State::done) << length;
  }
}

// What stands behind the % no control reads: line ends, blank tape.
TEST(Sender, ADc3BehindTheEndMarkLeavesTheRestUnsent) {
  const std::string program = "%\nO1\nM30\n%";
  for (const std::string& rest : {std::string("\n"), std::string("\r\n"), "\n" + std::string(10'000, '\0')}) {
    auto rules = rules_for("dc1-dc4");
    rules.percent = '%';  // the text is not punched here
    rules.window = static_cast<std::uint32_t>(program.size());
    Sender sender(rules, text_source(program + rest), at(0s));
    sender.on_bytes("\x11", at(1s));
    EXPECT_EQ(everything(sender, at(1s)), program);
    sender.on_bytes("\x13", at(1s));
    sender.tick(at(2s), 0);
    EXPECT_EQ(sender.state(), State::done) << rest.size();
    EXPECT_EQ(sender.counters().bytes, program.size());
  }
}

// The end mark is the one of the line's code: ER in EIA, where 25 is a V.
TEST(Sender, TheEndMarkIsThatOfTheLinesCode) {
  auto settings = default_settings("dc1-dc4");
  for (const auto& [code, mark] : {std::pair{tape::Code::ascii, 0x25}, {tape::Code::iso, 0xA5}, {tape::Code::eia, 0x0B}}) {
    settings.code = code;
    EXPECT_EQ(send_rules(settings).percent, mark);
  }
  settings.code = tape::Code::eia;
  auto rules = send_rules(settings);
  rules.window = 2;
  Sender sender(rules, text_source("\x80\x25\x80\x0B\x80"), at(0s));
  sender.on_bytes("\x11", at(1s));
  EXPECT_EQ(everything(sender, at(1s)), "\x80\x25");
  sender.on_bytes("\x13", at(1s));
  EXPECT_EQ(sender.state(), State::held) << "a V ends nothing";
}

// An end of block that the control has not got, and a second program behind the first, are not left out.
TEST(Sender, ADc3BeforeTheEndMarkHoldsTheRestBack) {
  for (const std::string text : {"O1\nM30\n", "%\nO1\nM30\n%\nO2\n%"}) {
    for (const std::size_t window : {6u, 9u, 10u}) {
      auto rules = rules_for("dc1-dc4");
      rules.percent = '%';
      rules.window = static_cast<std::uint32_t>(window);
      Sender sender(rules, text_source(text), at(0s));
      sender.on_bytes("\x11", at(1s));
      std::string all = everything(sender, at(1s));
      ASSERT_EQ(all.size(), std::min(window, text.size()));
      if (all == text) continue;
      sender.on_bytes("\x13", at(1s));
      EXPECT_EQ(sender.state(), State::held) << text << window;
      sender.on_bytes("\x11", at(2s));
      for (int i = 3; all.size() < text.size() && i < 20; ++i) all += everything(sender, at(i * 1s));
      EXPECT_EQ(all, text);
    }
  }
}

TEST(Sender, StopsOnDc3WithAndWithoutParityWithinItsQueue) {
  for (const char* stop : {"\x13", "\x93"}) {
    Sender sender(rules_for("dc1-dc4"), text_source(std::string(1'000, 'X')), at(0s));
    sender.on_bytes("\x11", at(0s));
    const auto first = everything(sender, at(0s));
    EXPECT_EQ(first.size(), 8u) << "no more under way than the control takes after its DC3";
    sender.on_bytes(stop, at(0s));
    EXPECT_EQ(sender.state(), State::held);
    EXPECT_TRUE(sender.hold_device());
    EXPECT_EQ(everything(sender, at(1h)), "");
    EXPECT_EQ(sender.counters().most_after_stop, 8u);
    sender.on_bytes("\x91", at(1h));
    EXPECT_EQ(everything(sender, at(1h)).size(), 8u);
    EXPECT_EQ(sender.counters().longest_hold, 1h);
  }
}

TEST(Sender, NeverMoreUnderWayThanTheWindow) {
  auto rules = rules_for("xon-xoff");
  Sender sender(rules, text_source(std::string(5'000, 'X')), at(0s));
  std::uint64_t handed = 0;
  const auto character = rules.character;
  for (Duration now{}; !sender.over() && now < 10s; now += 1ms) {
    handed += everything(sender, at(now)).size();
    const auto on_wire = static_cast<std::uint64_t>(now / character);
    EXPECT_LE(handed, on_wire + rules.window + 1) << "at " << now.count();
    sender.tick(at(now), 0);
  }
  EXPECT_EQ(handed, 5'000u);
  EXPECT_EQ(sender.state(), State::done);
}

TEST(Sender, ASlowDeviceIsBelieved) {
  Sender sender(rules_for("xon-xoff"), text_source(std::string(100, 'X')), at(0s));
  EXPECT_EQ(everything(sender, at(0s)).size(), 14u);
  EXPECT_TRUE(sender.peek(at(1s), 14).empty()) << "the device says that all is still queued";
  EXPECT_EQ(sender.peek(at(1s), 4).size(), 10u);
}

TEST(Sender, Cts) {
  Sender sender(rules_for("rts-cts"), text_source("ABC"), at(0s));
  Signals off{.known = true};
  sender.on_signals(off, at(0s));
  EXPECT_EQ(everything(sender, at(0s)), "");
  Signals on{.cts = true, .known = true};
  sender.on_signals(on, at(1s));
  EXPECT_EQ(everything(sender, at(1s)), "ABC");
}

TEST(Sender, PauseAndResumeAndDc3Together) {
  Sender sender(rules_for("xon-xoff"), text_source(std::string(100, 'X')), at(0s));
  sender.pause(at(0s));
  EXPECT_EQ(everything(sender, at(1s)), "");
  sender.on_bytes("\x13", at(1s));
  sender.resume(at(2s));
  EXPECT_EQ(sender.state(), State::held);
  sender.pause(at(3s));
  sender.on_bytes("\x11", at(4s));
  EXPECT_EQ(everything(sender, at(4s)), "") << "DC1 does not end a person's pause";
  sender.resume(at(5s));
  EXPECT_FALSE(everything(sender, at(5s)).empty());
}

TEST(Sender, CancelIsFinal) {
  Sender sender(rules_for("xon-xoff"), text_source(std::string(100, 'X')), at(0s));
  sender.cancel(at(0s));
  sender.resume(at(1s));
  sender.on_bytes("\x11", at(1s));
  EXPECT_EQ(everything(sender, at(2s)), "");
  EXPECT_EQ(sender.state(), State::cancelled);
}

TEST(Sender, EveryFaultEndsItByName) {
  for (const auto& [fault, name] : {std::pair{Fault::parity, "line_parity"},
                                    {Fault::framing, "line_framing"},
                                    {Fault::overrun, "line_overrun"},
                                    {Fault::line_break, "line_break"},
                                    {Fault::disconnected, "disconnected"}}) {
    Sender sender(rules_for("xon-xoff"), text_source(std::string(100, 'X')), at(0s));
    everything(sender, at(0s));
    sender.on_fault(fault, at(0s));
    EXPECT_EQ(sender.state(), State::failed);
    EXPECT_EQ(sender.reason(), name);
    sender.on_bytes("\x11", at(1s));
    EXPECT_EQ(everything(sender, at(1s)), "") << "nothing goes on by itself";
  }
}

TEST(Sender, TimeLimitsByName) {
  auto rules = rules_for("dc1-dc4");
  rules.start_limit = 10s;
  rules.hold_limit = 20s;
  Sender silent(rules, text_source("ABC"), at(0s));
  silent.tick(at(9s), 0);
  EXPECT_FALSE(silent.over());
  EXPECT_LE(silent.wake(at(9s)), at(10s));
  silent.tick(at(10s), 0);
  EXPECT_EQ(silent.reason(), "no_start");
  Sender dead(rules, text_source(std::string(100, 'X')), at(0s));
  dead.on_bytes("\x11", at(1s));
  dead.on_bytes("\x13", at(2s));
  dead.tick(at(21s), 0);
  EXPECT_FALSE(dead.over());
  dead.tick(at(22s), 0);
  EXPECT_EQ(dead.reason(), "held_too_long");
  Sender stuck(rules, text_source("ABC"), at(0s));
  stuck.on_bytes("\x11", at(1s));
  everything(stuck, at(1s));
  stuck.tick(at(40s), 3);
  EXPECT_EQ(stuck.reason(), "not_drained");
}

TEST(Sender, BlockDelayForControlsWithoutHandshake) {
  auto rules = rules_for("plain");
  rules.block_delay = 100ms;
  rules.window = 1'000;
  Sender sender(rules, text_source("G0\nG1\nM30\n"), at(0s));
  EXPECT_EQ(everything(sender, at(0s)), "G0\n");
  EXPECT_EQ(everything(sender, at(100ms)), "") << "counted from the last character on the wire";
  EXPECT_EQ(everything(sender, at(104ms)), "G1\n");
  EXPECT_EQ(everything(sender, sender.wake(at(105ms))), "M30\n");
  EXPECT_EQ(sender.counters().blocks, 3u);
}

class HalfSource final : public Source {
 public:
  Result read(std::span<char> into) override {
    if (asked_++ == 0) {
      into[0] = 'A';
      return {Status::data, 1};
    }
    return {Status::failed, 0};
  }
  std::string reason() const override { return "blob_unreadable"; }

 private:
  int asked_ = 0;
};

TEST(Sender, ASourceThatFailsIsNotAnEnd) {
  Sender sender(rules_for("xon-xoff"), std::make_unique<HalfSource>(), at(0s));
  EXPECT_EQ(everything(sender, at(0s)), "A");
  EXPECT_EQ(sender.state(), State::failed);
  EXPECT_EQ(sender.reason(), "blob_unreadable");
}

/// A control with 128 characters of buffer that reads unevenly, and a wire that takes one character a
/// character time.
struct World {
  World(Sender& the_sender, Duration the_character, unsigned seed)
      : sender(the_sender), character(the_character), random(seed) {}

  /// @return the characters the control has read. @param late longest delay with which the sender's thread
  /// runs.
  std::string run(Duration late, Duration limit) {
    Duration now{}, wake{}, next_on_wire{}, next_read{};
    sender_told(go(), now);
    while (!sender.over() && now < limit) {
      now += character / 4;
      while (!back.empty() && back.front().first <= now) {
        if (hardware)
          sender.on_signals(cts(back.front().second == kReady), at(now));
        else
          sender.on_bytes({&back.front().second, 1}, at(now));
        back.pop_front();
        wake = now;
      }
      if (now >= wake) {
        for (auto bytes = sender.peek(at(now), wire.size()); !bytes.empty();
             bytes = sender.peek(at(now), wire.size())) {
          if (wire.empty()) next_on_wire = std::max(next_on_wire, now);
          wire.insert(wire.end(), bytes.begin(), bytes.end());
          sender.wrote(bytes.size(), at(now));
        }
        sender.tick(at(now), wire.size());
        const Duration jitter(
            late.count() == 0 ? 0
                              : static_cast<Duration::rep>(random() % static_cast<unsigned>(late.count())));
        wake = std::max(sender.wake(at(now)) - at(0s), now) + jitter;
      }
      while (!wire.empty() && next_on_wire + character <= now) {
        next_on_wire += character;
        arrive(wire.front(), now);
        wire.pop_front();
        last_on_wire = now;
        if (first_on_wire == Duration{}) first_on_wire = now;
      }
      if (now >= next_read && reads) {
        if (!buffer.empty()) {
          read += buffer.front();
          buffer.pop_front();
        }
        next_read = now + character * (slow ? random() % 3 : 0);
        if (stopped && buffer.size() < 32) {
          stopped = false;
          sender_told(go(), now);
        }
        if (slow && random() % 200 == 0) next_read = now + character * (random() % 400);
      }
    }
    while (!buffer.empty()) {
      read += buffer.front();
      buffer.pop_front();
    }
    return read;
  }

  static constexpr char kReady = 'R', kNotReady = 'N';  ///< CTS, where it is used instead of DC1 and DC3
  static Signals cts(bool on) {
    Signals signals;
    signals.known = true;
    signals.cts = on;
    return signals;
  }
  const char* go() const { return hardware ? &kReady : "\x11"; }
  const char* halt() { return hardware ? &kNotReady : random() % 2 ? "\x93" : "\x13"; }

  void sender_told(const char* code, Duration now) {
    back.emplace_back(now + character * (1 + random() % 2), *code);
  }
  void arrive(char byte, Duration now) {
    if (stopped) most_after = std::max(most_after, ++after);
    buffer.push_back(byte);
    overflow = overflow || buffer.size() > 128;
    if (!stopped && (buffer.size() > 96 || (slow && random() % 300 == 0))) {
      stopped = true;
      after = 0;
      sender_told(halt(), now);
    }
    if (fault && ++arrived == fault_at) sender.on_fault(*fault, at(now));
  }

  Sender& sender;
  Duration character;
  std::mt19937 random;
  std::deque<char> wire, buffer;
  std::deque<std::pair<Duration, char>> back;
  std::string read;
  bool slow = true, reads = true, stopped = false, overflow = false, hardware = false;
  std::optional<Fault> fault;  ///< of the line, when so many characters have arrived
  std::size_t fault_at = 0, arrived = 0;
  unsigned after = 0, most_after = 0;
  Duration first_on_wire{}, last_on_wire{};
};

TEST(Sender, AThousandRandomTransfersLoseNothing) {
  std::mt19937 random(20'26);
  unsigned worst = 0, stops = 0;
  for (unsigned round = 0; round < 1'000; ++round) {
    std::string text;
    const std::size_t length = 1 + random() % 1'500;
    for (std::size_t i = 0; i < length; ++i) text += static_cast<char>("0123456789XYZGM. -\n"[random() % 19]);
    const auto settings = default_settings(round % 2 ? "dc1-dc4" : "xon-xoff");
    auto rules = send_rules(settings);
    rules.window = 8;
    Sender sender(rules, text_source(text), at(0s));
    World world(sender, rules.character, round);
    const auto read = world.run(rules.character * 8, 10min);
    ASSERT_EQ(sender.state(), State::done) << round << " " << sender.reason();
    ASSERT_EQ(read, text) << round;
    ASSERT_FALSE(world.overflow) << round;
    ASSERT_EQ(sender.counters().bytes, text.size());
    worst = std::max(worst, world.most_after);
    stops += sender.counters().stops;
  }
  EXPECT_LE(worst, 10u) << "FANUC: at most 10 characters after DC3 (PS0087)";
  EXPECT_GT(stops, 1'000u);
  RecordProperty("worst_after_stop", static_cast<int>(worst));
}

TEST(Sender, AThousandRandomTransfersWithInjectedFaultsAndCtsChanges) {
  constexpr const char* kProtocols[] = {"dc1-dc4", "xon-xoff", "rts-cts"};
  constexpr Fault kFaults[] = {Fault::parity, Fault::framing, Fault::overrun, Fault::line_break,
                               Fault::disconnected};
  std::mt19937 random(6);
  unsigned faults = 0, whole = 0, worst = 0;
  for (unsigned round = 0; round < 1'000; ++round) {
    std::string text;
    const std::size_t length = 50 + random() % 1'000;
    for (std::size_t i = 0; i < length; ++i) text += static_cast<char>("0123456789XYZGM. -\n"[random() % 19]);
    auto rules = send_rules(default_settings(kProtocols[round % 3]));
    rules.window = 8;
    Sender sender(rules, text_source(text), at(0s));
    World world(sender, rules.character, round);
    world.hardware = rules.obey_cts;
    if (random() % 2 != 0) {
      world.fault = kFaults[random() % std::size(kFaults)];
      world.fault_at = 1 + random() % (length - 30);
    }
    const auto read = world.run(rules.character * 8, 10min);
    ASSERT_FALSE(world.overflow) << round;
    worst = std::max(worst, world.most_after);
    if (world.fault) {
      ++faults;
      ASSERT_EQ(sender.state(), State::failed) << round;
      ASSERT_EQ(sender.reason(), name_of(*world.fault)) << round;
      ASSERT_TRUE(text.starts_with(read)) << round << ": nothing doubled, left out or in another order";
      ASSERT_GE(read.size(), world.fault_at);
      ASSERT_TRUE(sender.peek(at(10min), 0).empty()) << "nothing goes on by itself";
    } else {
      ++whole;
      ASSERT_EQ(sender.state(), State::done) << round << " " << sender.reason();
      ASSERT_EQ(read, text) << round;
    }
  }
  EXPECT_GT(faults, 400u);
  EXPECT_GT(whole, 400u);
  EXPECT_LE(worst, 10u);
}

double line_use(unsigned baud, unsigned after_stop, Duration late) {
  auto settings = default_settings("xon-xoff");
  settings.line.baud = baud;
  settings.after_stop = after_stop;
  const auto rules = send_rules(settings);
  Sender sender(rules, text_source(std::string(20'000, 'X')), at(0s));
  World world(sender, rules.character, 1);
  world.slow = false;
  world.run(late, 10min);
  EXPECT_EQ(sender.state(), State::done);
  return 19'999.0 * static_cast<double>(rules.character.count()) /
         static_cast<double>((world.last_on_wire - world.first_on_wire).count());
}

TEST(Sender, UsesTheLine) {
  EXPECT_GE(line_use(9'600, 10, 2ms), 0.99);
  EXPECT_GE(line_use(115'200, 64, 2ms), 0.99);
  EXPECT_GE(line_use(115'200, 10, 200us), 0.99);
}

}  // namespace
}  // namespace headstock::serial
