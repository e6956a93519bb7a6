// A port that is a machine's agent: "agent:12". The same record, page and commands as a line; the bytes go
// over the agent's own link, and nothing moves at the machine before its operator starts it.
#pragma once

#include <cstdint>
#include <string_view>

#include "server/dnc/dnc.hpp"

namespace headstock::dnc {

struct Unit;

/// @return the machine of "agent:12"; 0: no agent's address.
std::int64_t agent_of(std::string_view address);
/// Fills state and transfer.
void show_agent(const Unit& unit, const AgentCarrier& agents, PortView& view);

}  // namespace headstock::dnc
