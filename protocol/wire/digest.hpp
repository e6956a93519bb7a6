// SHA-256, running: the identity of every program and the proof that a resumed transfer goes on where it
// stopped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace headstock::wire {

/// Digest of a growing text. Not shared between threads.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&);
  Sha256& operator=(const Sha256&);
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void update(std::string_view bytes);
  void reset();
  /// Lower-case hex of everything so far; may go on growing afterwards.
  std::string hex() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Lower-case hex SHA-256 of `bytes`.
std::string sha256_hex(std::string_view bytes);
std::string to_hex(std::span<const unsigned char> bytes);
/// 64 lower-case hex digits.
bool is_sha256_hex(std::string_view text);
/// `bytes` random bytes from the operating system, as hex.
std::string random_hex(std::size_t bytes);

}  // namespace headstock::wire
