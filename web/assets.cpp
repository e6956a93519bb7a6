#include "web/assets.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstdint>

#include "web/assets_table.hpp"

namespace headstock::web {

const Asset* find(std::string_view path) {
  if (path.empty() || path == "/") path = "/index.html";
  // The table is sorted by path (embed.mjs).
  const auto end = kAssets + kAssetCount;
  const auto* at =
      std::lower_bound(kAssets, end, path, [](const Asset& a, std::string_view p) { return a.path < p; });
  return at != end && at->path == path ? at : nullptr;
}

std::size_t plain_size(const Asset& asset) {
  if (!asset.gzip) return asset.bytes.size();
  // RFC 1952 2.3.1: the last four bytes are the size of the original, least significant first.
  std::size_t size = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto byte = static_cast<std::uint8_t>(asset.bytes[asset.bytes.size() - 4 + i]);
    size |= static_cast<std::size_t>(byte) << (8 * i);
  }
  return size;
}

bool unpack(const Asset& asset, char* into) {
  if (!asset.gzip) {
    std::copy(asset.bytes.begin(), asset.bytes.end(), into);
    return true;
  }
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 16) != Z_OK) return false;
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(asset.bytes.data()));
  stream.avail_in = static_cast<uInt>(asset.bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(into);
  stream.avail_out = static_cast<uInt>(plain_size(asset));
  const bool done = inflate(&stream, Z_FINISH) == Z_STREAM_END;
  inflateEnd(&stream);
  return done;
}

}  // namespace headstock::web
