// Signing in through an OpenID Connect provider (authorization code flow with PKCE, RFC 7636). Optional:
// passwords stay possible, so that a shop whose provider is away can still be managed.
//
// The identity token is believed when the provider's published keys have signed it (token_signature.hpp) and
// issuer, audience, time and nonce are ours; beyond that everything goes over TLS, without it only on
// loopback.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <map>
#include <string>

#include "server/access/accounts.hpp"

namespace headstock::integrations {

struct ProviderSettings {
  std::string issuer;  ///< https://…; empty: not used
  std::string client_id, client_secret;
  std::string label;    ///< on the button
  bool create = false;  ///< may somebody unknown come in, with `role`?
  access::Role role = access::Role::viewer;
};
/// ---- store thread
ProviderSettings provider_settings(db::Database& db);
/// An empty secret keeps the old one. Refusals: forbidden, bad_value (where: the field).
void set_provider(db::Database& db, const access::Actor& actor, const ProviderSettings& settings);

/// What the provider's identity token says, once it has been found to be for us.
struct Identity {
  std::string external;  ///< issuer#subject
  std::string user, name;
};
/// @param token a JWT. @param key_set the provider's keys (JSON). Throws Refusal{provider_failed} (where:
/// what is wrong).
Identity identity_of(const std::string& token, const std::string& key_set, const ProviderSettings& settings,
                     const std::string& nonce, std::int64_t now_s);
/// The user of the identity, made if allowed. Refusals: unknown_person, wrong_sign_in (disabled).
db::UserRow user_of(db::Database& db, const Identity& identity, const ProviderSettings& settings,
                    std::int64_t now_ms);

class SignInProvider {
 public:
  SignInProvider(db::Store& store, db::Pool& worker) : store_(store), worker_(worker) {}

  struct Begun {
    std::string url;    ///< where the browser must go
    std::string state;  ///< comes back with it; a cookie keeps it in the same browser
  };
  /// Refusals: not_found (none is set up), provider_failed.
  boost::asio::awaitable<Begun> begin(std::string return_address);
  /// Refusals: provider_failed, unknown_person, wrong_sign_in.
  boost::asio::awaitable<access::Session> finish(std::string state, std::string code, std::string address);

 private:
  struct Open {
    std::string verifier, nonce, return_address, token_endpoint, keys_endpoint;
    std::int64_t until_ms = 0;
  };
  db::Store& store_;
  db::Pool& worker_;
  std::map<std::string, Open> open_;  ///< by state; network thread
};

}  // namespace headstock::integrations
