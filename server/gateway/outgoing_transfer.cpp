#include "server/gateway/outgoing_transfer.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "protocol/process/log.hpp"

namespace headstock::server {
namespace {

namespace asio = boost::asio;
using wire::Type;

constexpr std::chrono::milliseconds kReportEvery{200};
/// Hashing from the start after a restart lets others work in between.
constexpr std::uint64_t kHashSlice = 1u << 20;

}  // namespace

OutgoingTransfer::OutgoingTransfer(const asio::any_io_executor& executor, TransferState state,
                                   std::string name, std::shared_ptr<BlobReader> content, Changed changed)
    : executor_(executor),
      state_(std::move(state)),
      name_(std::move(name)),
      content_(std::move(content)),
      changed_(std::move(changed)),
      go_on_(executor),
      answered_(executor),
      ended_(executor) {
  state_.total = content_->size();
  marks_.push_back({0, wire::Sha256()});
}

void OutgoingTransfer::open_on(std::shared_ptr<wire::Connection> connection, std::uint32_t stream) {
  connection_ = std::move(connection);
  stream_ = stream;
  positioned_ = positioning_ = detached_since_open_ = false;
  limit_ = 0;
  const std::uint64_t attachment = ++attachment_;
  connection_->send(is_drip() ? Type::drip_open : Type::program_put, stream_,
                    wire::encode(wire::TransferOpen{state_.id, name_, state_.total, state_.sha256}));
  set_state("sending");
  asio::co_spawn(
      executor_, [self = shared_from_this(), attachment] { return self->send_loop(attachment); },
      asio::detached);
}

void OutgoingTransfer::resume_on(std::shared_ptr<wire::Connection> connection, std::uint32_t stream,
                                 const wire::Credit& credit) {
  connection_ = std::move(connection);
  stream_ = stream;
  positioned_ = positioning_ = detached_since_open_ = false;
  limit_ = 0;
  const std::uint64_t attachment = ++attachment_;
  set_state("sending");
  asio::co_spawn(
      executor_, [self = shared_from_this(), attachment] { return self->send_loop(attachment); },
      asio::detached);
  on_credit(credit);
}

void OutgoingTransfer::wait_for_machine() {
  accepted_ = true;
  set_state("waiting");
}

void OutgoingTransfer::detach() {
  if (finished_ || !connection_) return;
  connection_.reset();
  ++attachment_;
  detached_since_open_ = true;
  set_state("waiting");
  go_on_.notify();
  answered_.notify();
}

void OutgoingTransfer::on_credit(const wire::Credit& credit) {
  if (finished_ || !connection_) return;
  accepted_ = true;
  answered_.notify();
  if (credit.offset > state_.total || credit.granted > state_.total - credit.offset)
    return stop_sending("bad_credit");
  if (positioned_) return confirm(credit);
  if (positioning_) return;  // a second credit before the first was checked: the next one will do
  positioning_ = true;
  asio::co_spawn(
      executor_,
      [self = shared_from_this(), credit, attachment = attachment_]() -> asio::awaitable<void> {
        const bool found = co_await self->position(credit, attachment);
        if (!self->attached(attachment)) co_return;
        self->positioning_ = false;
        if (!found) co_return self->stop_sending("prefix_mismatch");
        self->positioned_ = true;
        self->confirm(credit);
      },
      asio::detached);
}

/// Brings sent_ and digest_ to where the machine stands, hashing from the nearest known position, and
/// compares.
asio::awaitable<bool> OutgoingTransfer::position(wire::Credit credit, std::uint64_t attachment) {
  while (marks_.size() > 1 && marks_.back().offset > credit.offset) marks_.pop_back();
  Mark at = marks_.front().offset > credit.offset ? Mark{0, wire::Sha256()} : marks_.back();
  std::string buffer(wire::kMaxDataBytes, '\0');
  while (at.offset < credit.offset) {
    const auto wanted =
        static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), credit.offset - at.offset));
    const std::size_t got = content_->read(at.offset, buffer.data(), wanted);
    if (got == 0) co_return false;
    at.digest.update({buffer.data(), got});
    if (at.offset / kHashSlice != (at.offset + got) / kHashSlice) {
      co_await asio::post(executor_, asio::use_awaitable);
      if (!attached(attachment)) co_return false;
    }
    at.offset += got;
  }
  sent_ = at.offset;
  digest_ = at.digest;
  marks_.clear();
  marks_.push_back(std::move(at));
  co_return digest_.hex() == credit.sha256;
}

void OutgoingTransfer::confirm(const wire::Credit& credit) {
  const auto mark = std::ranges::find(marks_, credit.offset, &Mark::offset);
  if (mark == marks_.end()) return stop_sending("bad_credit");
  if (mark->digest.hex() != credit.sha256) return stop_sending("prefix_mismatch");
  marks_.erase(marks_.begin(), mark);
  limit_ = std::max(limit_, credit.offset + credit.granted);
  state_.bytes = credit.offset;
  progress();
  go_on_.notify();
}

asio::awaitable<void> OutgoingTransfer::send_loop(std::uint64_t attachment) {
  const auto self = shared_from_this();
  std::string buffer(wire::kMaxDataBytes, '\0');
  while (attached(attachment)) {
    if (!positioned_ || (sent_ >= limit_ && sent_ < state_.total)) {
      co_await go_on_.wait();
      continue;
    }
    if (sent_ == state_.total) {
      if (digest_.hex() != state_.sha256) co_return stop_sending("blob_damaged");
      connection_->send(Type::data_end, stream_, wire::encode(wire::DataEnd{sent_, state_.sha256}));
      co_return;
    }
    const auto link = connection_;
    co_await link->room();
    if (!attached(attachment)) co_return;
    const auto wanted = static_cast<std::size_t>(
        std::min<std::uint64_t>(buffer.size(), std::min(limit_, state_.total) - sent_));
    const std::size_t got = content_->read(sent_, buffer.data(), wanted);
    if (got == 0) co_return stop_sending("blob_unreadable");
    const std::string_view piece(buffer.data(), got);
    digest_.update(piece);
    sent_ += got;
    marks_.push_back({sent_, digest_});
    connection_->send(Type::data, stream_, piece);
  }
}

void OutgoingTransfer::on_result(const wire::TransferResult& result) {
  if (finished_) return;
  if (!result.ok) return end("failed", result.reason.empty() ? "refused" : result.reason);
  if (result.bytes != state_.total || result.sha256 != state_.sha256) return end("failed", "bad_hash");
  accepted_ = true;
  state_.bytes = state_.total;
  end("done", "");
}

void OutgoingTransfer::cancel(const std::string& reason) {
  if (finished_) return;
  if (connection_)
    connection_->send(Type::transfer_cancel, stream_, wire::encode(wire::TransferCancel{state_.id, reason}));
  end("cancelled", reason);
}

void OutgoingTransfer::stop_sending(const std::string& reason) {
  log::error("transfer {} to machine {}: {}", state_.id, state_.machine, reason);
  if (connection_)
    connection_->send(Type::transfer_cancel, stream_, wire::encode(wire::TransferCancel{state_.id, reason}));
  end("failed", reason);
}

void OutgoingTransfer::end(const std::string& state, const std::string& reason) {
  if (finished_) return;
  const auto self = shared_from_this();  // whoever is told may let go of us
  finished_ = true;
  connection_.reset();
  state_.reason = reason;
  set_state(state);
  go_on_.notify();
  answered_.notify();
  ended_.notify();
}

void OutgoingTransfer::set_state(const std::string& state) {
  if (state_.state == state) return;
  state_.state = state;
  reported_ = std::chrono::steady_clock::now();
  changed_(state_);
}

void OutgoingTransfer::progress() {
  const auto now = std::chrono::steady_clock::now();
  if (now - reported_ < kReportEvery) return;
  reported_ = now;
  changed_(state_);
}

asio::awaitable<void> OutgoingTransfer::answered() {
  const auto self = shared_from_this();
  while (!accepted_ && !finished_ && !detached_since_open_) co_await answered_.wait();
}

asio::awaitable<void> OutgoingTransfer::ended() {
  const auto self = shared_from_this();
  while (!finished_) co_await ended_.wait();
}

}  // namespace headstock::server
