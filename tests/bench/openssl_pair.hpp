// The reference of the drip-feed benchmark: what `openssl s_server` moves to `openssl s_client` over TLS 1.3
// on the loopback, as two programs of the system's OpenSSL.
#pragma once

#include <cstdint>
#include <filesystem>

namespace headstock::bench {

/// @param folder for the pair's key and certificate, made at the first call.
/// @return MB/s from the first byte written into the one to the last read from the other; 0 when the programs
/// are not there or do not answer within a minute.
double openssl_pair_mb_s(const std::filesystem::path& folder, std::uint64_t bytes);

}  // namespace headstock::bench
