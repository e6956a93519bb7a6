// Variables that only the machine can answer: signals, clocks, counters (L18930-L19060, L19333-L19369).
#include "dialects/k2000tc/language.hpp"

namespace headstock::dialects::k2000tc {

using k2000::Error;

bool Language::jump_input(int /*which*/) const {
  return false;
}

Error Language::machine_variable(std::uint32_t /*number*/, Value& /*value*/) {
  return Error::no_variable;
}

Error Language::set_machine_variable(std::uint32_t /*number*/, const Value& /*value*/) {
  return Error::no_variable;
}

bool Language::write_out(Executor& ex, std::string text) {
  auto& message = ex.emit<interp::Message>();
  message.at = ex.at;
  message.text = std::move(text);
  return true;
}

}  // namespace headstock::dialects::k2000tc
