// Program texts as files named by their SHA-256: DATA/blobs/ab/cdef…, written to a temporary file, synced,
// renamed, and never written again. 100 MB and more stream through. Safe from any thread; one Writer on one
// thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "db/hash.hpp"

namespace headstock::db {

class Blobs {
 public:
  /// Removes what half-finished uploads of an earlier run left in DATA/blobs/incoming. Throws Error.
  explicit Blobs(std::filesystem::path data_folder);

  /// Receives one blob. Without finish() its temporary file vanishes with it.
  class Writer {
   public:
    ~Writer();
    Writer(Writer&&) noexcept;
    /// Throws Error{disk_full}: then only destruction makes sense.
    void append(std::string_view bytes);
    /// Syncs and puts it in place (or drops it when the same content is there already). @return its SHA-256.
    std::string finish();
    std::uint64_t bytes() const { return bytes_; }

   private:
    friend class Blobs;
    Writer(const Blobs& home, std::filesystem::path temporary, int file);
    const Blobs* home_;
    std::filesystem::path temporary_;
    int file_;
    Sha256 hash_;
    std::uint64_t bytes_ = 0;
  };
  Writer begin() const;

  /// Reads any part of one blob. Throws Error{corrupt} when the file has gone or has shrunk.
  class Reader {
   public:
    ~Reader();
    Reader(const Reader&) = delete;
    Reader& operator=(const Reader&) = delete;
    std::uint64_t size() const { return size_; }
    std::size_t read(std::uint64_t offset, char* into, std::size_t at_most) const;

   private:
    friend class Blobs;
    Reader(int file, std::uint64_t size) : file_(file), size_(size) {}
    int file_;
    std::uint64_t size_;
  };
  std::shared_ptr<Reader> open(const std::string& sha256) const;

  /// The whole text without reading it into memory: its pages come and go as the system likes.
  class Mapped {
   public:
    ~Mapped();
    Mapped(const Mapped&) = delete;
    Mapped& operator=(const Mapped&) = delete;
    std::string_view view() const { return {bytes_, size_}; }

   private:
    friend class Blobs;
    Mapped(const char* bytes, std::size_t size) : bytes_(bytes), size_(size) {}
    const char* bytes_;
    std::size_t size_;
  };
  std::shared_ptr<const Mapped> map(const std::string& sha256) const;

  /// Reads it all and compares. @return false when damaged or missing.
  bool verify(const std::string& sha256) const;
  std::filesystem::path path(const std::string& sha256) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace headstock::db
