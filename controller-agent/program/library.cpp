#include "program/library.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <utility>

#include "program/block_reader.hpp"

namespace headstock::program {
namespace {

namespace fs = std::filesystem;

// One program of a file that holds several.
class Section final : public Source {
 public:
  Section(std::unique_ptr<Source> whole, std::uint64_t begin, std::uint64_t end)
      : whole_(std::move(whole)), begin_(begin), end_(end), at_(begin) {
    whole_->seek(begin);
  }

  ReadResult read(std::span<char> buffer) override {
    if (at_ >= end_) return {ReadStatus::end, 0};
    const auto most = static_cast<std::size_t>(std::min<std::uint64_t>(buffer.size(), end_ - at_));
    const ReadResult got = whole_->read(buffer.first(most));
    at_ += got.bytes;
    return got;
  }

  bool seek(std::uint64_t byte_offset) override {
    if (byte_offset > end_ - begin_ || !whole_->seek(begin_ + byte_offset)) return false;
    at_ = begin_ + byte_offset;
    return true;
  }

 private:
  std::unique_ptr<Source> whole_;
  std::uint64_t begin_, end_, at_;
};

// "O1234" at the head of a line, after blanks and a tape mark.
bool program_head(std::string_view line, std::uint32_t& number) {
  const auto first = line.find_first_not_of(std::string_view("% \t\0", 4));
  if (first == line.npos || (line[first] != 'O' && line[first] != 'o' && line[first] != ':')) return false;
  const char* digits = line.data() + first + 1;
  const auto [end, error] = std::from_chars(digits, line.data() + line.size(), number);
  return error == std::errc() && end != digits;
}

bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::toupper(x) == std::toupper(y); });
}

bool is_number(std::string_view stem, std::uint32_t number) {
  std::uint32_t found = 0;
  if (stem.size() < 2 || (stem[0] != 'O' && stem[0] != 'o')) return false;
  const auto [end, error] = std::from_chars(stem.data() + 1, stem.data() + stem.size(), found);
  return error == std::errc() && end == stem.data() + stem.size() && found == number;
}

template <typename Fits>
std::unique_ptr<Source> open_in(const std::vector<fs::path>& folders, const Fits& fits) {
  for (const fs::path& folder : folders) {
    std::error_code error;
    std::vector<fs::path> found;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      if (entry.is_regular_file(error) && fits(entry.path())) found.push_back(entry.path());
    }
    if (found.empty()) continue;
    return source_from_file(std::min_element(found.begin(), found.end())->string());
  }
  return nullptr;
}

}  // namespace

void FilePrograms::add_folder(fs::path folder) {
  folders_.push_back(std::move(folder));
}

void FilePrograms::add_file(const fs::path& file) {
  if (const auto source = source_from_file(file.string())) index(*source, {file, nullptr, 0, 0});
}

void FilePrograms::add_text(std::string text) {
  texts_.push_back(std::make_unique<std::string>(std::move(text)));
  const auto source = source_from_view(*texts_.back());
  index(*source, {{}, texts_.back().get(), 0, 0});
}

void FilePrograms::index(Source& source, const Place& where) {
  // The reader owns its source; this one is the caller's, so it is lent.
  struct Lent final : Source {
    explicit Lent(Source& lent) : source(lent) {}
    ReadResult read(std::span<char> buffer) override { return source.read(buffer); }
    bool seek(std::uint64_t offset) override { return source.seek(offset); }
    Source& source;
  };
  BlockReader reader(std::make_unique<Lent>(source), 1'000'000);
  Line line;
  Place* open = nullptr;
  while (reader.next(line) == LineStatus::line) {
    std::uint32_t number = 0;
    if (!program_head(line.text, number)) continue;
    if (open != nullptr) open->end = line.byte_offset;
    const auto [entry, is_new] = places_.try_emplace(number, where);
    open = is_new ? &entry->second : nullptr;
    if (open != nullptr) open->begin = line.byte_offset;
  }
  if (open != nullptr) open->end = reader.byte_offset();
}

std::unique_ptr<Source> FilePrograms::open_number(std::uint32_t number) {
  if (const auto found = places_.find(number); found != places_.end()) {
    const Place& place = found->second;
    auto whole =
        place.text != nullptr ? source_from_view(*place.text) : source_from_file(place.file.string());
    if (whole != nullptr) return std::make_unique<Section>(std::move(whole), place.begin, place.end);
  }
  return open_in(folders_, [&](const fs::path& path) { return is_number(path.stem().string(), number); });
}

std::unique_ptr<Source> FilePrograms::open_name(std::string_view name) {
  return open_in(folders_, [&](const fs::path& path) {
    return same_name(path.filename().string(), name) || same_name(path.stem().string(), name);
  });
}

}  // namespace headstock::program
