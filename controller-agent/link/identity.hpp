// The agent's key and certificate on disk. Key, certificate and CA are one file, so that a cut cannot leave a
// key without its certificate; a renewed pair waits beside until the server has answered it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "protocol/wire/certificates.hpp"

namespace headstock::link {

struct Credentials {
  std::string key_pem, certificate_pem, ca_pem;
};

class Identity {
 public:
  /// Throws wire::CertificateError when the folder or a file in it cannot be used.
  explicit Identity(std::filesystem::path folder);

  bool enrolled() const { return current_.has_value() || next_.has_value(); }
  /// The pair to connect with: the renewed one first.
  const Credentials& credentials() const { return next_ ? *next_ : *current_; }
  bool trying_renewed() const { return next_.has_value(); }

  void store(const Credentials& credentials);
  void store_renewed(const Credentials& credentials);
  /// The server answered the renewed pair: the old one goes.
  void keep_renewed();
  /// The server does not know the renewed pair (it was cut before it could): back to the old one.
  void drop_renewed();

 private:
  std::filesystem::path current_file_, next_file_;
  std::optional<Credentials> current_, next_;
};

}  // namespace headstock::link
