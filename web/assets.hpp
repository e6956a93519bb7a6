// The browser application, embedded: one immutable table of files made at build time.
#pragma once

#include <cstddef>
#include <string_view>

namespace headstock::web {

/// One file of the application, ready to send. All views point at static storage.
struct Asset {
  std::string_view path;   ///< as in the address, "/index.html"
  std::string_view bytes;  ///< gzip when `gzip` is set: send `Content-Encoding: gzip`
  std::string_view mime;   ///< with the charset where it has one
  std::string_view etag;   ///< quoted, ready for the header; changes with the content
  bool gzip = false;
  bool immutable = false;  ///< the name carries a hash of the content: may be cached for a year
};

/// The file at this path ("/" is the page itself). Any thread.
/// @return nullptr when the application has no such file.
const Asset* find(std::string_view path);

/// The bytes as they were before compression, for a client that does not accept gzip.
/// @param into at least `plain_size(asset)` bytes. @return false if the embedded data are damaged.
std::size_t plain_size(const Asset& asset);
bool unpack(const Asset& asset, char* into);

}  // namespace headstock::web
