#include "operation/program_text.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace headstock::operation {
namespace {

constexpr std::size_t kLongestShown = 200;
constexpr std::size_t kMostSubprograms = 64;

class WindowedSource final : public program::Source {
 public:
  WindowedSource(std::unique_ptr<program::Source> source, std::shared_ptr<TextWindow> window)
      : source_(std::move(source)), window_(std::move(window)) {}

  program::ReadResult read(std::span<char> buffer) override {
    const program::ReadResult result = source_->read(buffer);
    if (result.status == program::ReadStatus::data) {
      window_->append(offset_, {buffer.data(), result.bytes});
      offset_ += result.bytes;
    }
    if (result.status == program::ReadStatus::failed) window_->broken = true;
    if (result.status != program::ReadStatus::wait) window_->arrived = true;
    return result;
  }
  bool seek(std::uint64_t byte_offset) override {
    if (!source_->seek(byte_offset)) return false;
    offset_ = byte_offset;
    return true;
  }

 private:
  std::unique_ptr<program::Source> source_;
  std::shared_ptr<TextWindow> window_;
  std::uint64_t offset_ = 0;
};

}  // namespace

void TextWindow::append(std::uint64_t offset, std::string_view bytes) {
  const std::uint64_t end = begin_ + text_.size();
  if (offset < begin_ || offset > end) {  // a jump out of what is kept
    begin_ = offset;
    text_.assign(bytes);
  } else if (offset + bytes.size() > end) {
    text_.append(bytes.substr(end - offset));
  }
  if (text_.size() > 2 * kKept) {
    const std::size_t surplus = text_.size() - kKept;
    text_.erase(0, surplus);
    begin_ += surplus;
  }
}

std::string TextWindow::line_at(std::uint64_t offset) const {
  if (offset < begin_ || offset >= begin_ + text_.size()) return {};
  const std::string_view rest = std::string_view(text_).substr(offset - begin_, kLongestShown);
  return std::string(rest.substr(0, rest.find_first_of("\r\n")));
}

std::unique_ptr<program::Source> windowed(std::unique_ptr<program::Source> source,
                                          std::shared_ptr<TextWindow> window) {
  return std::make_unique<WindowedSource>(std::move(source), std::move(window));
}

void WindowedPrograms::select(std::shared_ptr<program::Programs> memory) {
  memory_ = std::move(memory);
  windows_.clear();
  external_.reset();
}

std::unique_ptr<program::Source> WindowedPrograms::open_number(std::uint32_t number) {
  auto source = memory_ ? memory_->open_number(number) : nullptr;
  if (!source) return nullptr;
  if (windows_.size() >= kMostSubprograms && !windows_.contains(number)) return source;
  auto& window = windows_[number];
  if (!window) window = std::make_shared<TextWindow>();
  return windowed(std::move(source), window);
}

std::unique_ptr<program::Source> WindowedPrograms::open_external(std::uint32_t number) {
  auto source = memory_ ? memory_->open_external(number) : nullptr;
  if (!source) return nullptr;
  if (windows_.size() >= kMostSubprograms) windows_.clear();
  // Not the window of a resident program of that number.
  auto& window = windows_[number] = std::make_shared<TextWindow>();
  external_ = window;
  return windowed(std::move(source), window);
}

std::unique_ptr<program::Source> WindowedPrograms::open_name(std::string_view name) {
  return memory_ ? memory_->open_name(name) : nullptr;
}

std::string WindowedPrograms::line_at(std::uint32_t program, std::uint64_t offset) const {
  const auto found = windows_.find(program);
  return found == windows_.end() ? std::string() : found->second->line_at(offset);
}

std::uint64_t measure(program::Source& source) {
  std::array<char, 65'536> buffer;
  std::uint64_t total = 0;
  while (true) {
    const program::ReadResult result = source.read(buffer);
    if (result.status != program::ReadStatus::data)
      return result.status == program::ReadStatus::end ? total : 0;
    total += result.bytes;
  }
}

}  // namespace headstock::operation
