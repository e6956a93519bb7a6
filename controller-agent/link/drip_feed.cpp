#include "link/drip_feed.hpp"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <utility>
#include <vector>

#include "protocol/wire/digest.hpp"

namespace headstock::link {

struct DripFeed::Impl {
  Announced announced;
  std::function<void()> wake;
  mutable std::mutex mutex;
  std::vector<char> ring;
  std::uint64_t received = 0, consumed = 0, granted_end = 0;
  wire::Sha256 digest;  ///< of `received` bytes; the link's thread only
  bool left = false;      ///< the interpreter has what it needs
  bool complete = false;  ///< everything is here and proven
  Outcome outcome = Outcome::running;
  std::string reason;

  std::uint64_t grantable_end() const { return std::min(consumed + ring.size(), announced.bytes); }
  Grant grant_to(std::uint64_t end) {
    granted_end = end;
    return {received, digest.hex(), end - received};
  }
  void end(Outcome how, std::string why) {
    if (outcome != Outcome::running) return;
    outcome = how;
    reason = std::move(why);
  }
};

/// Reads what has arrived.
class DripSource final : public program::Source {
 public:
  explicit DripSource(std::shared_ptr<DripFeed> feed, DripFeed::Impl& impl)
      : feed_(std::move(feed)), impl_(impl) {}

  ~DripSource() override {
    {
      const std::scoped_lock lock(impl_.mutex);
      // A program ends with M30; what comes behind it (the final %) has arrived but is never read.
      if (impl_.complete) {
        impl_.end(DripFeed::Outcome::drained, "");
      } else if (impl_.outcome == DripFeed::Outcome::running && impl_.received == impl_.announced.bytes) {
        impl_.left = true;  // all is here; the proof of it is on its way
      } else {
        impl_.end(DripFeed::Outcome::closed, "closed_by_machine");
      }
    }
    impl_.wake();
  }

  program::ReadResult read(std::span<char> buffer) override {
    program::ReadResult result{program::ReadStatus::wait, 0};
    bool tell = false;
    {
      const std::scoped_lock lock(impl_.mutex);
      if (impl_.outcome == DripFeed::Outcome::drained) return {program::ReadStatus::end, 0};
      if (impl_.outcome != DripFeed::Outcome::running) return {program::ReadStatus::failed, 0};
      const std::uint64_t before = room();
      const auto count =
          static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), impl_.received - impl_.consumed));
      if (count > 0) {
        copy_out(buffer.first(count));
        impl_.consumed += count;
        result = {program::ReadStatus::data, count};
        // Told once, when the room passes a quarter of the buffer: not with every block.
        tell = before < threshold() && room() >= threshold();
      } else if (impl_.complete) {
        impl_.end(DripFeed::Outcome::drained, "");
        result.status = program::ReadStatus::end;
        tell = true;
      }
    }
    if (tell) impl_.wake();
    return result;
  }
  bool seek(std::uint64_t) override { return false; }

 private:
  /// Bytes that could be granted beyond what was.
  std::uint64_t room() const { return impl_.consumed + impl_.ring.size() - impl_.granted_end; }
  std::uint64_t threshold() const { return impl_.ring.size() / 4; }

  void copy_out(std::span<char> into) {
    const auto size = impl_.ring.size();
    const auto at = static_cast<std::size_t>(impl_.consumed % size);
    const std::size_t first = std::min(into.size(), size - at);
    std::memcpy(into.data(), impl_.ring.data() + at, first);
    std::memcpy(into.data() + first, impl_.ring.data(), into.size() - first);
  }

  std::shared_ptr<DripFeed> feed_;  // keeps impl_
  DripFeed::Impl& impl_;
};

DripFeed::DripFeed(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
DripFeed::~DripFeed() = default;

std::shared_ptr<DripFeed> DripFeed::make(Announced announced, std::size_t buffer_bytes,
                                         std::function<void()> wake) {
  auto impl = std::make_unique<Impl>();
  impl->announced = std::move(announced);
  impl->wake = std::move(wake);
  impl->ring.resize(std::clamp<std::size_t>(buffer_bytes, 64u << 10, 64u << 20));
  return std::shared_ptr<DripFeed>(new DripFeed(std::move(impl)));
}

const DripFeed::Announced& DripFeed::announced() const {
  return impl_->announced;
}

bool DripFeed::append(std::string_view bytes) {
  Impl& i = *impl_;
  std::uint64_t received = 0;
  {
    const std::scoped_lock lock(i.mutex);
    if (i.outcome != Outcome::running) return true;  // on its way when the feed ended
    if (i.complete || bytes.size() > i.granted_end - i.received) {
      i.end(Outcome::failed, "more_than_granted");
      return false;
    }
    received = i.received;
  }
  // Copied and hashed without the lock, so that the interpreter never waits for a hash: the room behind
  // `received` is nobody else's until the count says so.
  const auto size = i.ring.size();
  const auto at = static_cast<std::size_t>(received % size);
  const std::size_t first = std::min(bytes.size(), size - at);
  std::memcpy(i.ring.data() + at, bytes.data(), first);
  std::memcpy(i.ring.data(), bytes.data() + first, bytes.size() - first);
  i.digest.update(bytes);
  const std::scoped_lock lock(i.mutex);
  i.received += bytes.size();
  return true;
}

bool DripFeed::finish(std::uint64_t bytes, const std::string& sha256) {
  const std::scoped_lock lock(impl_->mutex);
  if (impl_->outcome != Outcome::running || impl_->complete) return true;
  const std::string have = impl_->digest.hex();
  if (bytes != impl_->announced.bytes || impl_->received != bytes || sha256 != impl_->announced.sha256 ||
      have != sha256) {
    impl_->end(Outcome::failed, "bad_hash");
    return false;
  }
  impl_->complete = true;
  if (impl_->left) impl_->end(Outcome::drained, "");
  return true;
}

void DripFeed::fail(const std::string& reason) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->end(Outcome::failed, reason);
}

std::optional<DripFeed::Grant> DripFeed::grant() {
  const std::scoped_lock lock(impl_->mutex);
  if (impl_->outcome != Outcome::running || impl_->complete) return std::nullopt;
  const std::uint64_t end = impl_->grantable_end();
  const bool rest = end == impl_->announced.bytes && end > impl_->granted_end;
  if (!rest && end < impl_->granted_end + impl_->ring.size() / 4) return std::nullopt;
  return impl_->grant_to(end);
}

std::optional<DripFeed::Grant> DripFeed::resume() {
  const std::scoped_lock lock(impl_->mutex);
  if (impl_->outcome != Outcome::running) return std::nullopt;
  return impl_->grant_to(impl_->grantable_end());
}

DripFeed::State DripFeed::state() const {
  const std::scoped_lock lock(impl_->mutex);
  return {impl_->outcome, impl_->received, impl_->received - impl_->consumed, impl_->reason};
}

std::unique_ptr<program::Source> DripFeed::source() {
  return std::make_unique<DripSource>(shared_from_this(), *impl_);
}

}  // namespace headstock::link
