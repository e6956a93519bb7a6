// What the two GSK lathes share: GSK 218T and 2000TB/TC are descendants of the GSK 980T and speak its
// language.
#pragma once

#include "dialects/dialect.hpp"

namespace headstock::dialects::gsk {

/// A dialect with the family's alarm numbers, M codes, words and lathe rules; a folder fills in what is its
/// own.
Dialect family();

}  // namespace headstock::dialects::gsk
