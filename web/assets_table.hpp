// The table embed.mjs writes: sorted by path.
#pragma once

#include <cstddef>

#include "web/assets.hpp"

namespace headstock::web {

extern const Asset kAssets[];
extern const std::size_t kAssetCount;

}  // namespace headstock::web
