// Programs on their way to machines: one put a machine at a time, drip-feeds that outlive a connection, reads
// back.
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "server/gateway/gateway_impl.hpp"

namespace headstock::server {
namespace {

namespace asio = boost::asio;
using wire::Type;

/// A put whose machine does not come back is given up; its bytes stay there for the next attempt.
constexpr std::chrono::minutes kPutWaits{15};

}  // namespace

void Gateway::Impl::on_credit(AgentSession& session, const wire::Frame& frame, const wire::Credit& credit) {
  const auto found = transfers.find(credit.transfer);
  if (found == transfers.end() || found->second->state().machine != session.machine() ||
      found->second->finished()) {
    session.connection()->send(Type::transfer_cancel, frame.stream,
                               wire::encode(wire::TransferCancel{credit.transfer, "unknown_transfer"}));
    return;
  }
  // A new stream number keeps late frames of an older connection apart.
  if (frame.type == Type::drip_resume)
    found->second->resume_on(session.connection(), frame.stream, credit);
  else
    found->second->on_credit(credit);
}

void Gateway::Impl::on_result(AgentSession& session, const wire::TransferResult& result) {
  const auto found = transfers.find(result.transfer);
  if (found != transfers.end() && found->second->state().machine == session.machine())
    found->second->on_result(result);
  session.connection()->send(Type::transfer_closed, 0,
                             wire::encode(wire::TransferCancel{result.transfer, ""}));
}

std::shared_ptr<OutgoingTransfer> Gateway::Impl::add_transfer(std::uint64_t id, std::int64_t machine,
                                                              const char* kind, std::string name,
                                                              std::string sha256,
                                                              std::shared_ptr<BlobReader> content) {
  TransferState state;
  state.id = id;
  state.machine = machine;
  state.kind = kind;
  state.sha256 = std::move(sha256);
  const auto changed = [weak = weak_from_this()](const TransferState& now) {
    const auto self = weak.lock();
    if (!self) return;
    const bool over = now.state == "done" || now.state == "failed" || now.state == "cancelled";
    const std::uint64_t ended = now.id;
    if (!self->stopped_) self->host_.transfer_changed(now);
    if (over) self->transfers.erase(ended);
  };
  const auto transfer = std::make_shared<OutgoingTransfer>(io.get_executor(), std::move(state),
                                                           std::move(name), std::move(content), changed);
  transfers[id] = transfer;
  return transfer;
}

/// One put a machine at a time; the others wait their turn.
asio::awaitable<void> Gateway::Impl::put_turn(std::int64_t machine) {
  const auto self = shared_from_this();
  auto& turn = put_turns[machine];
  if (!turn) turn = std::make_shared<wire::Signal>(io.get_executor());
  const auto signal = turn;
  while (putting.contains(machine) && !stopped_) co_await signal->wait();
  putting.insert(machine);
}

asio::awaitable<TransferState> Gateway::Impl::put(std::uint64_t id, std::int64_t machine, std::string name,
                                                  std::string sha256, std::shared_ptr<BlobReader> content) {
  const auto self = shared_from_this();
  TransferState refused;
  refused.id = id;
  refused.machine = machine;
  refused.kind = "put";
  refused.sha256 = sha256;
  refused.total = content->size();
  refused.state = "failed";
  if (transfers.contains(id))
    refused.reason = "busy";
  else if (!session_of(machine))
    refused.reason = "not_connected";
  if (!refused.reason.empty()) {
    host_.transfer_changed(refused);
    co_return refused;
  }
  refused.state = "queued";
  host_.transfer_changed(refused);
  co_await put_turn(machine);
  const auto transfer =
      add_transfer(id, machine, "put", std::move(name), std::move(sha256), std::move(content));
  if (const auto session = session_of(machine))
    transfer->open_on(session->connection(), session->next_stream());
  else
    transfer->fail("not_connected");

  std::weak_ptr<OutgoingTransfer> weak = transfer;
  auto watch = [self, weak]() -> asio::awaitable<void> {
    // Gives up a put that has waited too long for its machine.
    asio::steady_timer timer(self->io);
    auto waiting_since = std::chrono::steady_clock::now();
    while (true) {
      timer.expires_after(std::chrono::seconds(1));
      co_await timer.async_wait(kAsTuple);
      const auto watched = weak.lock();
      if (!watched || watched->finished() || self->stopped_) co_return;
      const auto now = std::chrono::steady_clock::now();
      if (watched->state().state != "waiting")
        waiting_since = now;
      else if (now - waiting_since > kPutWaits)
        watched->fail("link_lost");
    }
  };
  asio::co_spawn(io, watch, asio::detached);
  co_await transfer->ended();
  putting.erase(machine);
  if (const auto turn = put_turns.find(machine); turn != put_turns.end()) turn->second->notify();
  co_return transfer->state();
}

asio::awaitable<TransferState> Gateway::put(std::uint64_t transfer, std::int64_t machine, std::string name,
                                            std::string sha256, std::shared_ptr<BlobReader> content) {
  return impl_->put(transfer, machine, std::move(name), std::move(sha256), std::move(content));
}

asio::awaitable<MachineAnswer> Gateway::drip(std::uint64_t transfer, std::int64_t machine, std::string name,
                                             std::string sha256, std::shared_ptr<BlobReader> content) {
  const auto impl = impl_;
  if (impl->transfers.contains(transfer)) co_return MachineAnswer{false, "busy"};
  const auto session = impl->session_of(machine);
  if (!session) co_return MachineAnswer{false, "not_connected"};
  const auto drip =
      impl->add_transfer(transfer, machine, "drip", std::move(name), std::move(sha256), std::move(content));
  drip->open_on(session->connection(), session->next_stream());
  co_await drip->answered();
  if (drip->accepted()) co_return MachineAnswer{true, ""};
  // The link went before an answer: whether the machine has it is not known, so it must not go on by itself.
  if (!drip->finished()) drip->fail("link_lost");
  co_return MachineAnswer{false, drip->state().reason};
}

void Gateway::offer_again(std::uint64_t transfer, std::int64_t machine, std::string name, std::string sha256,
                          std::shared_ptr<BlobReader> content) {
  const auto drip =
      impl_->add_transfer(transfer, machine, "drip", std::move(name), std::move(sha256), std::move(content));
  drip->wait_for_machine();
}

asio::awaitable<ProgramText> Gateway::get(std::int64_t machine, std::string name) {
  const auto session = impl_->session_of(machine);
  if (!session) {
    ProgramText none;
    none.reason = "not_connected";
    none.name = std::move(name);
    co_return none;
  }
  // Numbers of reads back are of this connection only; the top bit keeps them apart from the store's
  // transfers.
  const std::uint64_t transfer = (std::uint64_t{1} << 63) | session->next_stream();
  co_return co_await session->get(transfer, std::move(name));
}

bool Gateway::cancel(std::uint64_t transfer, const std::string& reason) {
  const auto found = impl_->transfers.find(transfer);
  if (found == impl_->transfers.end()) return false;
  const auto cancelled = found->second;
  cancelled->cancel(reason);
  return true;
}

}  // namespace headstock::server
