#include "server/access/password.hpp"

#include <openssl/evp.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "db/hash.hpp"
#include "db/refusal.hpp"

namespace headstock::access {
namespace {

constexpr std::size_t kHashBytes = 32, kSaltBytes = 16;

std::string scrypt_hex(const std::string& password, const std::string& salt_hex, const ScryptCost& cost) {
  std::array<unsigned char, kHashBytes> out{};
  const std::uint64_t n = 1ull << cost.log_n;
  // 128·N·r bytes is what scrypt needs; the limit only has to be above it.
  const std::uint64_t memory = 128 * n * cost.r * 2 + (1u << 20);
  if (EVP_PBE_scrypt(password.data(), password.size(),
                     reinterpret_cast<const unsigned char*>(salt_hex.data()), salt_hex.size(), n, cost.r,
                     cost.p, memory, out.data(), out.size()) != 1)
    throw std::runtime_error("scrypt failed");
  return db::to_hex({reinterpret_cast<const char*>(out.data()), out.size()});
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const auto at = text.find(separator);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

bool number(std::string_view text, unsigned low, unsigned high, unsigned& into) {
  const auto result = std::from_chars(text.data(), text.data() + text.size(), into);
  return result.ec == std::errc() && result.ptr == text.data() + text.size() && into >= low && into <= high;
}

}  // namespace

std::string hash_password(const std::string& password, ScryptCost cost) {
  const std::string salt = db::random_hex(kSaltBytes);
  std::string text = "scrypt$";
  for (const unsigned figure : {cost.log_n, cost.r, cost.p}) text.append(std::to_string(figure)).append("$");
  return text.append(salt).append("$").append(scrypt_hex(password, salt, cost));
}

bool verify_password(const std::string& password, const std::string& hash) {
  const auto parts = split(hash, '$');
  ScryptCost cost;
  if (parts.size() != 6 || parts[0] != "scrypt" || !number(parts[1], 1, 20, cost.log_n) ||
      !number(parts[2], 1, 32, cost.r) || !number(parts[3], 1, 16, cost.p)) {
    scrypt_hex(password, "no such user", ScryptCost{});
    return false;
  }
  return db::equal_secret(scrypt_hex(password, std::string(parts[4]), cost), parts[5]);
}

namespace {

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

/// What guessers begin with, and the factory passwords of these controls repeated to length.
constexpr std::string_view kCommon[] = {
    "password",  "password1", "passw0rd",  "12345678",  "123456789", "1234567890", "87654321",  "qwertyui", "qwerty123",
    "11111111",  "88888888",  "66666666",  "1q2w3e4r",  "iloveyou",  "abcd1234",   "abc12345",  "a1234567", "admin123",
    "admin1234", "administrator", "headstock", "headstock1", "changeme", "letmein1", "welcome1", "woaini1314", "1234512345"};

}  // namespace

void demand_good_password(const std::string& password, const std::string& user, std::int64_t least) {
  std::int64_t characters = 0;
  for (const char c : password) characters += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  const std::string plain = lower(password);
  if (characters < least || password.size() > 1000) throw db::Refusal("weak_password", std::to_string(least));
  if (!user.empty())
    if (const auto at = plain.find(lower(user)); at != std::string::npos && plain.size() - user.size() < 4)
      throw db::Refusal("weak_password", "user");
  const bool same = plain.find_first_not_of(plain.front()) == std::string::npos;
  if (same || std::ranges::find(kCommon, plain) != std::end(kCommon)) throw db::Refusal("common_password");
}

std::string random_password() {
  static constexpr std::string_view kLetters = "abcdefghijkmnpqrstuvwxyz23456789";  // no l, o, 0, 1
  static_assert(kLetters.size() == 32);
  std::array<unsigned char, 16> raw{};
  if (RAND_bytes(raw.data(), static_cast<int>(raw.size())) != 1)
    throw std::runtime_error("the system has no random numbers");
  std::string text;
  for (const unsigned char byte : raw) text += kLetters[byte % 32];
  return text;
}

}  // namespace headstock::access
