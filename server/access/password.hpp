// scrypt password hashes (RFC 7914 through OpenSSL), N=2^15 r=8 p=1: about a tenth of a second, 32 MiB. Any
// thread, but never the network's or the store's.
#pragma once

#include <cstdint>
#include <string>

namespace headstock::access {

struct ScryptCost {
  unsigned log_n = 15, r = 8, p = 1;
};

/// `scrypt$15$8$1$<salt hex>$<hash hex>`
std::string hash_password(const std::string& password, ScryptCost cost = {});
/// Constant time in the hash; takes as long for an unusable hash, so that a missing user cannot be told from
/// a wrong password.
bool verify_password(const std::string& password, const std::string& hash);
/// Throws Refusal{weak_password} (where: the least length): at least `least` characters, at most 1,000 bytes, more
/// than the user's name and three characters; Refusal{common_password}: one that everybody tries first, or one character again and again.
void demand_good_password(const std::string& password, const std::string& user, std::int64_t least = 8);
/// 16 characters without look-alikes, for first sign-ins.
std::string random_password();

}  // namespace headstock::access
