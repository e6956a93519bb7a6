#include "server/dnc/agent_port.hpp"

#include <boost/asio/co_spawn.hpp>
#include <charconv>
#include <utility>

#include "db/refusal.hpp"
#include "protocol/process/log.hpp"
#include "server/dnc/service.hpp"

namespace headstock::dnc {

using boost::asio::awaitable;

namespace {

constexpr std::string_view kScheme = "agent:";

/// The transfer as ports show theirs.
db::PortTransferRow as_port_transfer(const Unit& unit, const db::TransferRow& from) {
  db::PortTransferRow row;
  row.id = from.id;
  row.port = unit.row.id;
  row.kind = from.kind == "drip" ? "drip" : "send";
  row.state = from.state;
  row.program = from.program;
  row.revision = from.revision;
  row.name = from.name;
  row.sha256 = from.sha256;
  row.bytes = from.bytes;
  row.total = from.total;
  row.reason = from.reason;
  row.by = from.by;
  row.created_ms = from.created_ms;
  row.started_ms = from.started_ms;
  row.ended_ms = from.ended_ms;
  return row;
}

}  // namespace

std::int64_t agent_of(std::string_view address) {
  if (!address.starts_with(kScheme)) return 0;
  address.remove_prefix(kScheme.size());
  std::int64_t machine = 0;
  const auto [end, error] = std::from_chars(address.data(), address.data() + address.size(), machine);
  return error == std::errc() && end == address.data() + address.size() && machine > 0 ? machine : 0;
}

void show_agent(const Unit& unit, const AgentCarrier& agents, PortView& view) {
  const bool connected = agents.is_connected && agents.is_connected(unit.agent);
  view.now.state = !connected ? "closed" : unit.to_agent ? "busy" : "listening";
  if (unit.to_agent) view.transfer = as_port_transfer(unit, *unit.to_agent);
}

awaitable<db::PortTransferRow> Dnc::Impl::send_to_agent(access::Actor actor, std::int64_t port,
                                                        SendWish wish) {
  // A restart in the middle is done at the machine, whose own control knows its state.
  if (wish.from_line > 1 || wish.queue || wish.armed) throw db::Refusal("not_for_agents");
  if (!agents.send) throw db::Refusal("not_connected");
  const auto machine = unit(port).agent;
  const auto row = co_await agents.send(std::move(actor), machine, wish.program, wish.revision, wish.drip);
  Unit& at = unit(port);
  if (!row.ended_ms) at.to_agent = row;
  changed(port);
  co_return as_port_transfer(at, row);
}

void Dnc::Impl::cancel_agent(const access::Actor& actor, const Unit& at) {
  if (!at.to_agent) throw db::Refusal("nothing_under_way");
  boost::asio::co_spawn(
      io,
      [self = shared_from_this(), actor, transfer = at.to_agent->id]() -> awaitable<void> {
        co_await self->agents.cancel(actor, transfer);
      },
      [](std::exception_ptr error) {
        if (error) log::warning("a transfer to an agent could not be cancelled: it is over");
      });
}

void Dnc::set_agents(AgentCarrier agents) {
  impl_->agents = std::move(agents);
}

void Dnc::agent_transfer(const db::TransferRow& row) {
  for (auto& [id, at] : impl_->units) {
    if (at->agent == 0 || at->agent != row.machine) continue;
    if (!row.ended_ms) {
      at->to_agent = row;
    } else if (at->to_agent && at->to_agent->id == row.id) {
      at->to_agent.reset();
    }
    impl_->changed(id);
  }
}

}  // namespace headstock::dnc
