#include "server/integrations/sign_in_provider.hpp"

#include <curl/curl.h>
#include <openssl/evp.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "db/access_store.hpp"
#include "db/hash.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/access/audit.hpp"
#include "server/integrations/token_signature.hpp"

namespace headstock::integrations {
namespace {

using boost::asio::awaitable;
using nlohmann::json;

constexpr std::int64_t kPatienceMs = 600'000;
constexpr std::size_t kMostOpen = 1'000;
constexpr std::size_t kMostBytes = 1u << 20;
constexpr std::int64_t kClockSlackS = 120;

[[noreturn]] void failed(const std::string& why) {
  throw db::Refusal("provider_failed", why);
}

bool is_trustworthy(const std::string& url) {
  return url.starts_with("https://") || url.starts_with("http://127.0.0.1:") ||
         url.starts_with("http://localhost:");
}

std::size_t collect(char* bytes, std::size_t size, std::size_t count, void* user) {
  auto& text = *static_cast<std::string*>(user);
  if (text.size() + size * count > kMostBytes) return 0;
  text.append(bytes, size * count);
  return size * count;
}

/// GET, or POST with a form. Worker thread.
json fetch_json(const std::string& url, const std::string& form, const std::string& user_password) {
  if (!is_trustworthy(url)) failed("only https: " + url);
  const std::unique_ptr<CURL, void (*)(CURL*)> handle(curl_easy_init(), &curl_easy_cleanup);
  std::string answer;
  curl_easy_setopt(handle.get(), CURLOPT_URL, url.c_str());
  curl_easy_setopt(handle.get(), CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(handle.get(), CURLOPT_WRITEFUNCTION, collect);
  curl_easy_setopt(handle.get(), CURLOPT_WRITEDATA, &answer);
  curl_easy_setopt(handle.get(), CURLOPT_TIMEOUT, 15L);
  curl_easy_setopt(handle.get(), CURLOPT_NOSIGNAL, 1L);
  if (!form.empty()) curl_easy_setopt(handle.get(), CURLOPT_POSTFIELDS, form.c_str());
  if (!user_password.empty()) {
    curl_easy_setopt(handle.get(), CURLOPT_HTTPAUTH, static_cast<long>(CURLAUTH_BASIC));
    curl_easy_setopt(handle.get(), CURLOPT_USERPWD, user_password.c_str());
  }
  const CURLcode result = curl_easy_perform(handle.get());
  if (result != CURLE_OK) failed(curl_easy_strerror(result));
  long status = 0;
  curl_easy_getinfo(handle.get(), CURLINFO_RESPONSE_CODE, &status);
  json parsed = json::parse(answer, nullptr, false);
  if (status != 200 || !parsed.is_object()) failed("status " + std::to_string(status));
  return parsed;
}

std::string text_in(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::string url_part(const std::string& text) {
  static constexpr char kDigits[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0 || c == '-' || c == '.' || c == '_' || c == '~')
      out += c;
    else
      out.append(1, '%').append(1, kDigits[byte >> 4]).append(1, kDigits[byte & 15]);
  }
  return out;
}

std::string base64_url(const std::string& bytes) {
  std::string out(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  out.resize(static_cast<std::size_t>(length));
  while (!out.empty() && out.back() == '=') out.pop_back();
  for (char& c : out) c = c == '+' ? '-' : c == '/' ? '_' : c;
  return out;
}

/// The challenge of a verifier: base64url(SHA-256).
std::string challenge_of(const std::string& verifier) {
  const std::string hex = db::sha256_hex(verifier);
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2)
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return base64_url(bytes);
}

bool is_for(const json& claims, const std::string& client) {
  const auto audience = claims.find("aud");
  if (audience == claims.end()) return false;
  if (audience->is_string()) return audience->get<std::string>() == client;
  // Several: then it must say that we are the party it was made for.
  return audience->is_array() && std::ranges::find(*audience, json(client)) != audience->end() &&
         text_in(claims, "azp") == client;
}

}  // namespace

ProviderSettings provider_settings(db::Database& db) {
  const auto of = [&db](const char* key) { return db::setting(db, key).value_or(""); };
  ProviderSettings settings{
      of("provider.issuer"),        of("provider.client_id"),
      of("provider.client_secret"), of("provider.label"),
      of("provider.create") == "1", access::role_from(of("provider.role")).value_or(access::Role::viewer)};
  return settings;
}

void set_provider(db::Database& db, const access::Actor& actor, const ProviderSettings& settings) {
  access::demand(actor, access::Action::manage_users);
  if (!settings.issuer.empty() && !is_trustworthy(settings.issuer)) throw db::Refusal("bad_value", "issuer");
  if (!settings.issuer.empty() && settings.client_id.empty()) throw db::Refusal("bad_value", "client_id");
  db::Transaction transaction(db);
  db::put_setting(db, "provider.issuer", settings.issuer);
  db::put_setting(db, "provider.client_id", settings.client_id);
  if (!settings.client_secret.empty()) db::put_setting(db, "provider.client_secret", settings.client_secret);
  db::put_setting(db, "provider.label", settings.label);
  db::put_setting(db, "provider.create", settings.create ? "1" : "0");
  db::put_setting(db, "provider.role", std::string(access::to_string(settings.role)));
  access::record(db, actor, "settings.provider", "settings",
                 {{"issuer", settings.issuer},
                  {"create", settings.create ? "yes" : "no"},
                  {"role", std::string(access::to_string(settings.role))}});
  transaction.commit();
}

Identity identity_of(const std::string& token, const std::string& key_set, const ProviderSettings& settings,
                     const std::string& nonce, std::int64_t now_s) {
  verify_signature(token, key_set);
  const auto first = token.find('.'), second = token.find('.', first + 1);
  const json claims =
      json::parse(from_base64_url(token.substr(first + 1, second - first - 1)), nullptr, false);
  if (!claims.is_object()) failed("token");
  if (text_in(claims, "iss") != settings.issuer) failed("issuer");
  if (!is_for(claims, settings.client_id)) failed("audience");
  const auto expiry = claims.find("exp");
  if (expiry == claims.end() || !expiry->is_number() ||
      expiry->get<double>() + static_cast<double>(kClockSlackS) < static_cast<double>(now_s))
    failed("expired");
  if (nonce.empty() || text_in(claims, "nonce") != nonce) failed("nonce");
  Identity identity;
  const std::string subject = text_in(claims, "sub");
  if (subject.empty() || subject.size() > 255) failed("subject");
  identity.external = settings.issuer + "#" + subject;
  identity.user = text_in(claims, "preferred_username");
  if (identity.user.empty()) identity.user = text_in(claims, "email");
  if (identity.user.empty()) identity.user = subject;
  identity.name = text_in(claims, "name");
  return identity;
}

db::UserRow user_of(db::Database& db, const Identity& identity, const ProviderSettings& settings,
                    std::int64_t now_ms) {
  if (auto known = db::user_external(db, identity.external)) {
    if (known->disabled) throw db::Refusal("wrong_sign_in");
    return *known;
  }
  if (!settings.create) throw db::Refusal("unknown_person", identity.user);
  db::UserRow row;
  for (const char c : identity.user)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' || c == '_' || c == '@')
      row.user += c;
  if (row.user.empty()) row.user = "person";
  row.user.resize(std::min<std::size_t>(row.user.size(), 56));
  // Never somebody who is here already: a name at the provider is no proof of being that person.
  const std::string wanted = row.user;
  for (int i = 2; db::user_named(db, row.user); ++i) row.user = wanted + "." + std::to_string(i);
  row.name = identity.name.empty() ? row.user : identity.name.substr(0, 200);
  row.role = access::to_string(settings.role);
  row.language = "zh";
  row.password = "";  // no password fits: signs in at the provider only
  row.external = identity.external;
  row.created_ms = now_ms;
  row.id = db::insert_user(db, row);
  access::record(db, access::Actor{}, "user.create", access::subject("user", row.id),
                 {{"user", row.user}, {"role", row.role}, {"external", row.external}});
  return row;
}

awaitable<SignInProvider::Begun> SignInProvider::begin(std::string return_address) {
  const auto read = [](db::Database& db) { return provider_settings(db); };
  const ProviderSettings settings = co_await store_.run(read);
  if (settings.issuer.empty()) throw db::Refusal("not_found", "provider");
  const auto ask = [&] { return fetch_json(settings.issuer + "/.well-known/openid-configuration", "", ""); };
  const json found = co_await worker_.run(ask);
  if (text_in(found, "issuer") != settings.issuer) failed("issuer");
  const std::string where = text_in(found, "authorization_endpoint");
  if (!is_trustworthy(where)) failed("authorization_endpoint");
  const auto now = db::now_ms();
  std::erase_if(open_, [now](const auto& one) { return one.second.until_ms < now; });
  if (open_.size() >= kMostOpen) failed("busy");
  Open open{db::random_hex(32),         db::random_hex(16),
            std::move(return_address),  text_in(found, "token_endpoint"),
            text_in(found, "jwks_uri"), now + kPatienceMs};
  Begun begun;
  begun.state = db::random_hex(16);
  begun.url = where + (where.find('?') == std::string::npos ? "?" : "&") +
              "response_type=code&scope=openid%20profile%20email&client_id=" + url_part(settings.client_id) +
              "&redirect_uri=" + url_part(open.return_address) + "&state=" + begun.state +
              "&nonce=" + open.nonce +
              "&code_challenge_method=S256&code_challenge=" + challenge_of(open.verifier);
  open_[begun.state] = std::move(open);
  co_return begun;
}

awaitable<access::Session> SignInProvider::finish(std::string state, std::string code, std::string address) {
  const auto found = open_.find(state);
  if (found == open_.end() || found->second.until_ms < db::now_ms()) failed("state");
  const Open open = std::move(found->second);
  open_.erase(found);  // once only
  const auto read = [](db::Database& db) { return provider_settings(db); };
  const ProviderSettings settings = co_await store_.run(read);
  const std::string form = "grant_type=authorization_code&code=" + url_part(code) +
                           "&redirect_uri=" + url_part(open.return_address) +
                           "&client_id=" + url_part(settings.client_id) + "&code_verifier=" + open.verifier;
  const std::string basic = settings.client_secret.empty()
                                ? ""
                                : url_part(settings.client_id) + ":" + url_part(settings.client_secret);
  const auto ask = [&] { return fetch_json(open.token_endpoint, form, basic); };
  const json answer = co_await worker_.run(ask);
  // Asked for at every sign-in: keys change, and one that was withdrawn must not be good a moment longer.
  const auto ask_keys = [&] { return fetch_json(open.keys_endpoint, "", ""); };
  const json keys = co_await worker_.run(ask_keys);
  const auto now = db::now_ms();
  const Identity identity =
      identity_of(text_in(answer, "id_token"), keys.dump(), settings, open.nonce, now / 1000);
  const auto start = [&](db::Database& db) {
    db::Transaction transaction(db);
    db::UserRow user = user_of(db, identity, settings, now);
    user.last_sign_in_ms = now;
    db::update_user(db, user);
    auto session = access::start_session(db, user, address, "provider", now);
    transaction.commit();
    return session;
  };
  co_return co_await store_.run(start);
}

}  // namespace headstock::integrations
