#include "link/program_request.hpp"

#include "link/program_name.hpp"

namespace headstock::link {

using program::ReadResult;
using program::ReadStatus;

/// Between the interpreter, who waits, and the link, who brings the program.
struct ProgramRequests::Waiting {
  std::mutex mutex;
  std::unique_ptr<program::Source> stream;
  bool failed = false;
  bool given_up = false;  ///< the interpreter has gone (reset)

  void fail() {
    const std::scoped_lock lock(mutex);
    if (!stream) failed = true;
  }
};

class RequestedSource final : public program::Source {
 public:
  explicit RequestedSource(std::shared_ptr<ProgramRequests::Waiting> waiting)
      : waiting_(std::move(waiting)) {}
  ~RequestedSource() override {
    std::unique_ptr<program::Source> stream;  // its end is told without the lock
    const std::scoped_lock lock(waiting_->mutex);
    waiting_->given_up = true;
    stream = std::move(waiting_->stream);
  }
  ReadResult read(std::span<char> buffer) override {
    const std::scoped_lock lock(waiting_->mutex);
    if (waiting_->stream) return waiting_->stream->read(buffer);
    return {waiting_->failed ? ReadStatus::failed : ReadStatus::wait, 0};
  }
  bool seek(std::uint64_t) override { return false; }

 private:
  std::shared_ptr<ProgramRequests::Waiting> waiting_;
};

bool same_program(std::string_view a, std::string_view b) {
  if (a == b) return true;
  const auto number = number_in_name(a);
  return number && number == number_in_name(b);
}

ProgramRequests::ProgramRequests(std::function<void()> wake) : wake_(std::move(wake)) {}
ProgramRequests::~ProgramRequests() = default;

std::unique_ptr<program::Source> ProgramRequests::open(const std::string& name) {
  auto waiting = std::make_shared<Waiting>();
  {
    const std::scoped_lock lock(mutex_);
    if (!up_) return nullptr;
    entries_[++last_] = {name, waiting, false};
  }
  wake_();
  return std::make_unique<RequestedSource>(std::move(waiting));
}

bool ProgramRequests::ask(const std::string& name) {
  {
    const std::scoped_lock lock(mutex_);
    if (!up_) return false;
    entries_[++last_] = {name, nullptr, false};
  }
  wake_();
  return true;
}

void ProgramRequests::link_is_up() {
  const std::scoped_lock lock(mutex_);
  up_ = true;
}

void ProgramRequests::link_is_lost() {
  const std::scoped_lock lock(mutex_);
  up_ = false;
  for (auto& [id, entry] : entries_)
    if (entry.waiting) entry.waiting->fail();
  entries_.clear();
}

std::vector<ProgramRequests::Asked> ProgramRequests::take_unsent() {
  const std::scoped_lock lock(mutex_);
  std::vector<Asked> unsent;
  for (auto& [id, entry] : entries_) {
    if (!entry.sent) unsent.push_back({id, entry.name});
    entry.sent = true;
  }
  return unsent;
}

std::optional<std::string> ProgramRequests::answered(std::uint64_t id, bool accepted, const std::string&) {
  const std::scoped_lock lock(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return std::nullopt;
  const Entry entry = found->second;
  // An accepted one is over when its stream has been handed over; that may have been before this word.
  if (!accepted && entry.waiting) entry.waiting->fail();
  if (!accepted || !entry.waiting) entries_.erase(found);
  return entry.waiting ? std::nullopt : std::optional(entry.name);
}

bool ProgramRequests::wanted(std::string_view name) const {
  const std::scoped_lock lock(mutex_);
  for (const auto& [id, entry] : entries_)
    if (entry.waiting && same_program(entry.name, name)) return true;
  return false;
}

bool ProgramRequests::hand_over(std::string_view name, std::unique_ptr<program::Source> stream) {
  const std::scoped_lock lock(mutex_);
  for (auto at = entries_.begin(); at != entries_.end(); ++at) {
    const auto waiting = at->second.waiting;
    if (!waiting || !same_program(at->second.name, name)) continue;
    entries_.erase(at);
    const std::scoped_lock also(waiting->mutex);
    if (waiting->given_up) return false;
    waiting->stream = std::move(stream);
    return true;
  }
  return false;
}

}  // namespace headstock::link
