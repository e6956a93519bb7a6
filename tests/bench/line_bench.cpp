// Line use: a program over a real pseudo-terminal whose far end takes characters no faster than the line
// would carry them, and loses the time in which there was none. The reference is the line itself: speed over
// bits a character.
#include <boost/asio/io_context.hpp>
#include <cstdio>
#include <string>

#include "protocol/serial/port/line.hpp"
#include "protocol/serial/port/prompt_thread.hpp"
#include "protocol/serial/protocols.hpp"
#include "tests/unit/serial/simulated_control.hpp"

namespace {

using namespace headstock::serial;

bool measure(std::uint32_t baud, std::uint32_t after_stop, double seconds) {
  SimulatedControl control;
  auto settings = default_settings("dc1-dc4");
  settings.line = *settings_of(std::to_string(baud) + "-8-N-1-software");
  settings.after_stop = after_stop;
  boost::asio::io_context io;
  Line line(io.get_executor(), *address_of(control.device()), settings.line, {});
  line.open();
  while (!line.is_open()) io.run_one();
  const double possible = settings.line.characters_s();
  const std::string text(static_cast<std::size_t>(possible * seconds), 'X');
  SimulatedControl::Behaviour paced;
  paced.stops = false;
  paced.baud = baud;
  SendReport report;
  line.send(send_rules(settings), text_source(text), [&](const SendReport& now) { report = now; });
  control.begin(paced, text.size());
  while (!report.over()) {
    io.run_one();
    if (io.stopped()) io.restart();
  }
  const bool whole = control.read_all() == text;
  const double use = control.characters_s() / possible;
  std::printf("%6u baud, control takes %2u after DC3: %.0f of %.0f characters/s, line use %.2f %%%s\n", baud,
              after_stop, control.characters_s(), possible, use * 100, whole ? "" : "  CHARACTERS LOST");
  return whole && use >= 0.99;
}

}  // namespace

/// bench_line [SECONDS]: 0 when every line is used to 99 % at least.
int main(int count, char** arguments) {
  const double seconds = count > 1 ? std::stod(arguments[1]) : 5;
  if (!serve_promptly()) std::printf("no priority: what else this computer does is in the figures\n");
  bool good = measure(9'600, 10, seconds);
  good = measure(115'200, 64, seconds) && good;
  return good ? 0 : 1;
}
