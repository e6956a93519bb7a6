// The shop's own certificate authority and what agents need of it (OpenSSL 3, EC P-256).
//
// The server makes its CA at first start; nothing else ever signs. A certificate for an agent names one
// machine
// (`CN=agent-<id>`, client authentication only, one year), the server's certificate is for server
// authentication only, so an agent's certificate can never pose as the server. Agents pin the CA, hence they
// need not check the server's host name.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace headstock::wire {

/// A key or certificate cannot be made, read or written; the message says which file and why.
class CertificateError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct CertificateInfo {
  std::string common_name, serial_hex;
  std::int64_t not_before_s = 0, not_after_s = 0;  ///< Unix time
};
/// Throws CertificateError.
CertificateInfo read_certificate(std::string_view pem);
/// In the last third of its life.
bool due_for_renewal(const CertificateInfo& certificate, std::int64_t now_s);
/// Lower-case hex SHA-256 of the certificate (DER).
std::string fingerprint(std::string_view pem);

/// "agent-12" → 12; 0 when it is not an agent's name.
std::int64_t machine_of_name(std::string_view common_name);

struct KeyAndRequest {
  std::string key_pem, request_pem;
};
/// A new private key and the request to have it certified.
KeyAndRequest make_key_and_request(const std::string& common_name);

/// One-time token `HS1-<secret>-<CA fingerprint>`: 32 hex digits of secret, 64 of fingerprint.
struct EnrolmentToken {
  std::string secret, ca_fingerprint;
};
std::string format_token(const EnrolmentToken& token);
std::optional<EnrolmentToken> parse_token(std::string_view text);
std::string make_secret();

struct IssuedCertificate {
  std::string pem, serial_hex;
};

/// Lifetimes; tests make expired ones.
struct Validity {
  std::int64_t not_before_s = 0, not_after_s = 0;
};

class Authority {
 public:
  /// Opens `folder`, makes CA and server certificate when there are none, and renews the server's certificate
  /// when it is due or lacks a name. Private keys are 0600. Throws CertificateError.
  Authority(const std::filesystem::path& folder, const std::vector<std::string>& host_names);
  ~Authority();
  Authority(Authority&&) noexcept;
  Authority& operator=(Authority&&) noexcept;

  const std::string& ca_pem() const;
  const std::string& server_pem() const;
  const std::string& server_key_pem() const;
  const std::string& ca_fingerprint() const;

  /// Signs an agent's request for one machine; the name in the request does not matter. One year from now
  /// unless told. Throws CertificateError for what is not a sound request of a P-256 key.
  IssuedCertificate sign(std::string_view request_pem, std::int64_t machine,
                         std::optional<Validity> validity = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Writes a file in one step with mode 0600. Throws CertificateError.
void write_private_file(const std::filesystem::path& path, std::string_view text);
/// @return nullopt when there is none. Throws CertificateError when it cannot be read.
std::optional<std::string> read_small_file(const std::filesystem::path& path);

}  // namespace headstock::wire
