#include "program/source.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace headstock::program {
namespace {

template <typename Text>
class TextSource final : public Source {
 public:
  explicit TextSource(std::string_view text) : text_(text) {}

  ReadResult read(std::span<char> buffer) override {
    if (at_ >= text_.size()) return {ReadStatus::end, 0};
    const std::size_t bytes = std::min(buffer.size(), text_.size() - at_);
    std::memcpy(buffer.data(), text_.data() + at_, bytes);
    at_ += bytes;
    return {ReadStatus::data, bytes};
  }

  bool seek(std::uint64_t byte_offset) override {
    if (byte_offset > text_.size()) return false;
    at_ = static_cast<std::size_t>(byte_offset);
    return true;
  }

 private:
  Text text_;
  std::size_t at_ = 0;
};

class FileSource final : public Source {
 public:
  explicit FileSource(std::FILE* file) : file_(file) { std::setvbuf(file_, nullptr, _IONBF, 0); }
  ~FileSource() override { std::fclose(file_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  ReadResult read(std::span<char> buffer) override {
    const std::size_t bytes = std::fread(buffer.data(), 1, buffer.size(), file_);
    if (bytes > 0) return {ReadStatus::data, bytes};
    return {std::ferror(file_) != 0 ? ReadStatus::failed : ReadStatus::end, 0};
  }

  bool seek(std::uint64_t byte_offset) override {
    return fseeko(file_, static_cast<off_t>(byte_offset), SEEK_SET) == 0;
  }

 private:
  std::FILE* file_;
};

}  // namespace

std::unique_ptr<Source> source_from_text(std::string_view text) {
  return std::make_unique<TextSource<std::string>>(text);
}

std::unique_ptr<Source> source_from_view(std::string_view text) {
  return std::make_unique<TextSource<std::string_view>>(text);
}

std::unique_ptr<Source> source_from_file(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return nullptr;
  return std::make_unique<FileSource>(file);
}

}  // namespace headstock::program
