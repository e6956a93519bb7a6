// SHA-256 in pieces, hex, and random numbers for secrets (OpenSSL behind it).
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace headstock::db {

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;
  void add(std::string_view bytes);
  /// 64 lower-case hex digits. Only once.
  std::string hex();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

std::string sha256_hex(std::string_view bytes);
std::string to_hex(std::string_view bytes);
/// Random hex for tokens and ids: 2 digits a byte. Throws when the system has no randomness.
std::string random_hex(std::size_t bytes);
/// Compares in a time that does not depend on where they differ.
bool equal_secret(std::string_view a, std::string_view b);

}  // namespace headstock::db
