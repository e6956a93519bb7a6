// Programs over one connection: into the memory, back from it, and drip-fed.

#include <algorithm>
#include <boost/asio/co_spawn.hpp>

#include "link/session.hpp"
#include "protocol/process/log.hpp"
#include "protocol/wire/digest.hpp"

namespace headstock::link {
namespace {

namespace asio = boost::asio;
using wire::Type;

constexpr std::uint64_t kPutWindow = 1u << 20;
constexpr std::size_t kMaxDrips = 4, kMaxPuts = 8;

}  // namespace

// ---- programs into the memory

void Session::result(wire::TransferResult result) {
  connection_->send(Type::transfer_result, 0, wire::encode(result));
}

void Session::grant_put(std::uint32_t stream, Put& put) {
  const std::uint64_t offset = put.incoming->offset();
  put.granted_end = std::min(put.bytes, offset + kPutWindow);
  connection_->send(Type::credit, stream,
                    wire::encode(wire::Credit{put.transfer, offset, put.incoming->prefix_sha256(),
                                              put.granted_end - offset}));
}

void Session::on_put(std::uint32_t stream, const wire::TransferOpen& open) {
  MemoryResult why;
  if (puts_.size() >= kMaxPuts) why.reason = "busy";
  auto incoming = why.ok() ? parts_->memory.begin_put(open.name, open.bytes, open.sha256, why) : nullptr;
  if (!incoming) return result({open.transfer, false, 0, "", why.reason});
  Put& put = puts_[stream];
  put = {open.transfer, open.bytes, open.sha256, std::move(incoming), 0};
  grant_put(stream, put);
}

void Session::finish_put(std::uint32_t stream, bool ok, const std::string& reason) {
  auto node = puts_.extract(stream);
  if (node.empty()) return;
  const Put& put = node.mapped();
  result({put.transfer, ok, put.incoming->offset(), ok ? put.sha256 : "", reason});
}

asio::awaitable<void> Session::send_program(std::uint32_t stream, wire::ProgramGet request) {
  const auto self = shared_from_this();
  const auto found = parts_->memory.find(request.name);
  auto source = found ? parts_->memory.open_name(request.name) : nullptr;
  if (!source) {
    result({request.transfer, false, 0, "", "not_found"});
    co_return;
  }
  wire::Sha256 digest;
  std::uint64_t bytes = 0;
  std::string buffer(wire::kMaxDataBytes, '\0');
  while (connection_->open()) {
    co_await connection_->room();
    const auto read = source->read({buffer.data(), buffer.size()});
    if (read.status == program::ReadStatus::end) {
      connection_->send(Type::data_end, stream, wire::encode(wire::DataEnd{bytes, digest.hex()}));
      result({request.transfer, true, bytes, digest.hex(), ""});
      co_return;
    }
    if (read.status != program::ReadStatus::data) {
      result({request.transfer, false, bytes, "", "disk_error"});
      co_return;
    }
    const std::string_view piece(buffer.data(), read.bytes);
    digest.update(piece);
    bytes += piece.size();
    connection_->send(Type::data, stream, piece);
  }
}

// ---- drip-feed

void Session::send_credit(Type type, const OpenTransfers::Drip& drip, const DripFeed::Grant& grant) {
  connection_->send(type, drip.stream,
                    wire::encode(wire::Credit{drip.feed->announced().transfer, grant.offset,
                                              grant.prefix_sha256, grant.granted}));
}

DripFeed* Session::drip_of(std::uint32_t stream) {
  for (auto& [id, drip] : parts_->transfers.drips)
    if (drip.stream == stream) return drip.feed.get();
  return nullptr;
}

void Session::on_drip_open(std::uint32_t stream, const wire::TransferOpen& open) {
  auto& drips = parts_->transfers.drips;
  if (const auto held = drips.find(open.transfer); held != drips.end()) {
    // Offered again (the server was restarted): it goes on where it is, if it is the same program.
    const auto& announced = held->second.feed->announced();
    if (announced.sha256 != open.sha256 || announced.bytes != open.bytes)
      return result({open.transfer, false, 0, "", "another_program"});
    held->second.stream = stream;
    if (const auto grant = held->second.feed->resume()) send_credit(Type::credit, held->second, *grant);
    return;
  }
  if (drips.size() >= kMaxDrips) return result({open.transfer, false, 0, "", "busy"});
  auto feed = DripFeed::make({open.transfer, open.name, open.bytes, open.sha256},
                             parts_->options.drip_buffer_bytes, parts_->wake_drips);
  if (parts_->requests.wanted(open.name)) {
    if (!parts_->requests.hand_over(open.name, feed->source()))
      return result({open.transfer, false, 0, "", "closed_by_machine"});
  } else {
    const auto outcome = parts_->host.open_stream(open.name, open.sha256, feed->source(), open.bytes);
    if (!outcome.accepted) return result({open.transfer, false, 0, "", outcome.reason});
  }
  const auto& drip = drips[open.transfer] = {std::move(feed), stream};
  if (const auto grant = drip.feed->resume()) send_credit(Type::credit, drip, *grant);
}

void Session::drips_changed() {
  auto& [drips, unconfirmed] = parts_->transfers;
  for (auto at = drips.begin(); at != drips.end();) {
    const auto state = at->second.feed->state();
    if (state.outcome == DripFeed::Outcome::running) {
      if (active())
        if (const auto grant = at->second.feed->grant()) send_credit(Type::credit, at->second, *grant);
      ++at;
      continue;
    }
    // The result is kept until the server has confirmed it: it may be lost with the link.
    const bool ok = state.outcome == DripFeed::Outcome::drained;
    const wire::TransferResult outcome{at->first, ok, state.received,
                                       ok ? at->second.feed->announced().sha256 : "", state.reason};
    unconfirmed[at->first] = outcome;
    if (active()) result(outcome);
    at = drips.erase(at);
  }
}

void Session::on_data(const wire::Frame& frame) {
  if (const auto found = puts_.find(frame.stream); found != puts_.end()) {
    Put& put = found->second;
    const MemoryResult written = put.incoming->append(frame.body);
    if (!written.ok()) return finish_put(frame.stream, false, written.reason);
    if (put.granted_end - std::min(put.granted_end, put.incoming->offset()) <= kPutWindow / 2 &&
        put.granted_end < put.bytes)
      grant_put(frame.stream, put);
    return;
  }
  if (DripFeed* feed = drip_of(frame.stream); feed && !feed->append(frame.body)) drips_changed();
}

void Session::on_data_end(std::uint32_t stream, const wire::DataEnd& end) {
  if (const auto found = puts_.find(stream); found != puts_.end()) {
    const MemoryResult finished = found->second.incoming->finish();
    return finish_put(stream, finished.ok(), finished.reason);
  }
  if (DripFeed* feed = drip_of(stream)) {
    feed->finish(end.bytes, end.sha256);
    drips_changed();
  }
}

void Session::on_cancel(const wire::TransferCancel& cancel) {
  for (const auto& [stream, put] : puts_)
    if (put.transfer == cancel.transfer) return finish_put(stream, false, "cancelled");
  const auto& drips = parts_->transfers.drips;
  if (const auto found = drips.find(cancel.transfer); found != drips.end()) {
    log::warning("link: drip-feed {} ended by the server: {}", cancel.transfer, cancel.reason);
    found->second.feed->fail(cancel.reason.empty() ? "cancelled" : cancel.reason);
    drips_changed();
  }
}

// ---- programs that this machine asks for

void Session::requests_changed() {
  if (!active()) return;
  for (const auto& asked : parts_->requests.take_unsent())
    connection_->send(Type::program_request, 0, wire::encode(wire::ProgramGet{asked.id, asked.name}));
}

}  // namespace headstock::link
