// The programs a controller can call, from files: a folder of programs, and files that hold several of them.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "program/source.hpp"

namespace headstock::program {

/// Sub-programs by number or name. Looked up in the order in which they were added.
class FilePrograms final : public Programs {
 public:
  /// Files O1234, O1234.nc, o1234.txt … and files by name in one folder.
  void add_folder(std::filesystem::path folder);
  /// A file that may hold several programs, each beginning with its O number. Read once for their places.
  void add_file(const std::filesystem::path& file);
  /// The same for a text. It is kept.
  void add_text(std::string text);

  std::unique_ptr<Source> open_number(std::uint32_t number) override;
  std::unique_ptr<Source> open_name(std::string_view name) override;

 private:
  struct Place {
    std::filesystem::path file;
    const std::string* text = nullptr;
    std::uint64_t begin = 0, end = 0;
  };
  void index(Source& source, const Place& where);

  std::vector<std::filesystem::path> folders_;
  std::vector<std::unique_ptr<std::string>> texts_;
  std::map<std::uint32_t, Place> places_;
};

}  // namespace headstock::program
