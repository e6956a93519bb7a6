// The words for the reasons with which machines and the server refuse or end something ("not_armed",
// "timeout" …). The keys travel; the words are looked up where they are shown. Constants: any thread, no
// allocation.
#pragma once

#include <string_view>

namespace headstock::protocol {

struct ReasonText {
  std::string_view key, en, zh;
};

/// An unknown key (of a newer agent) gives the key itself in both languages; an empty key gives empty texts.
ReasonText reason_text(std::string_view key);

}  // namespace headstock::protocol
