// The signature of an identity token (JWS compact form, RFC 7515) held against the provider's published keys
// (JSON Web Key Set, RFC 7517). Only signatures with a public key are taken (RFC 7518 3.3-3.5): a token that
// names `none`, or a shared secret where a public key is published, is refused, whatever else it says. Any
// thread.
#pragma once

#include <string>

namespace headstock::integrations {

/// The bytes of unpadded base64url text. Throws Refusal{provider_failed}: other characters, or no whole
/// bytes.
std::string from_base64_url(const std::string& text);

/// Returns when one of the keys has signed the token: of the kind its algorithm needs, meant for signatures,
/// and named by the token if it names one. RSA keys below 2,048 bits are not used (RFC 7518 3.3). Throws
/// Refusal{provider_failed}, where: token · keys · algorithm · key (none fits) · signature.
void verify_signature(const std::string& token, const std::string& key_set);

}  // namespace headstock::integrations
