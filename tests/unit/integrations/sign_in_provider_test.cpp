// Identity tokens: signed by the provider's published key, for us, of now, asked for by us. Everything else is refused.
#include "server/integrations/sign_in_provider.hpp"

#include <gtest/gtest.h>
#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ec.h>
#include <openssl/ecdsa.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rsa.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "db/refusal.hpp"
#include "server/integrations/token_signature.hpp"

namespace headstock::integrations {
namespace {

using nlohmann::json;

constexpr std::int64_t kNow = 1'800'000'000;

std::string encoded(const std::string& bytes) {
  std::string out(4 * ((bytes.size() + 2) / 3) + 1, '\0');
  out.resize(static_cast<std::size_t>(EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                                                      reinterpret_cast<const unsigned char*>(bytes.data()),
                                                      static_cast<int>(bytes.size()))));
  while (out.ends_with('=')) out.pop_back();
  for (char& c : out) c = c == '+' ? '-' : c == '/' ? '_' : c;
  return out;
}

std::string bytes_of(const BIGNUM* number, int size) {
  std::string out(static_cast<std::size_t>(size), '\0');
  BN_bn2binpad(number, reinterpret_cast<unsigned char*>(out.data()), size);
  return out;
}

/// The provider's side: a key, how it is published, and what it signs.
class Signer {
 public:
  static Signer rsa(const std::string& name, std::size_t bits = 2048) { return {EVP_RSA_gen(bits), "RSA", name}; }
  static Signer ec(const std::string& name, const char* curve = "P-256") { return {EVP_EC_gen(curve), "EC", name}; }

  json published() const {
    json key = {{"kty", type_}, {"kid", name_}, {"use", "sig"}};
    const auto put = [&](const char* field, const char* parameter, int size) {
      BIGNUM* number = nullptr;
      EXPECT_EQ(EVP_PKEY_get_bn_param(key_.get(), parameter, &number), 1);
      key[field] = encoded(bytes_of(number, size != 0 ? size : BN_num_bytes(number)));
      BN_free(number);
    };
    if (type_ == "RSA") {
      put("n", OSSL_PKEY_PARAM_RSA_N, 0);
      put("e", OSSL_PKEY_PARAM_RSA_E, 0);
    } else {
      key["crv"] = coordinate() == 32 ? "P-256" : "P-384";
      put("x", OSSL_PKEY_PARAM_EC_PUB_X, coordinate());
      put("y", OSSL_PKEY_PARAM_EC_PUB_Y, coordinate());
    }
    return key;
  }

  std::string token(const json& claims, const std::string& algorithm, json header = json::object()) const {
    header["alg"] = algorithm;
    if (!header.contains("kid")) header["kid"] = name_;
    const std::string text = encoded(header.dump()) + "." + encoded(claims.dump());
    return text + "." + encoded(signature(text, algorithm));
  }

 private:
  struct Free {
    void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
  };
  Signer(EVP_PKEY* key, std::string type, std::string name) : key_(key), type_(std::move(type)), name_(std::move(name)) {}
  int coordinate() const { return (EVP_PKEY_get_bits(key_.get()) + 7) / 8; }

  std::string signature(const std::string& text, const std::string& algorithm) const {
    EVP_MD_CTX* digest = EVP_MD_CTX_new();
    EVP_PKEY_CTX* context = nullptr;
    const std::string hash = "SHA" + algorithm.substr(2);
    EXPECT_EQ(EVP_DigestSignInit_ex(digest, &context, hash.c_str(), nullptr, nullptr, key_.get(), nullptr), 1);
    if (algorithm.starts_with("PS")) {
      EVP_PKEY_CTX_set_rsa_padding(context, RSA_PKCS1_PSS_PADDING);
      EVP_PKEY_CTX_set_rsa_pss_saltlen(context, RSA_PSS_SALTLEN_DIGEST);
    }
    std::size_t size = 0;
    const auto* bytes = reinterpret_cast<const unsigned char*>(text.data());
    EXPECT_EQ(EVP_DigestSign(digest, nullptr, &size, bytes, text.size()), 1);
    std::string out(size, '\0');
    EXPECT_EQ(EVP_DigestSign(digest, reinterpret_cast<unsigned char*>(out.data()), &size, bytes, text.size()), 1);
    out.resize(size);
    EVP_MD_CTX_free(digest);
    if (type_ == "RSA") return out;
    const auto* der = reinterpret_cast<const unsigned char*>(out.data());
    ECDSA_SIG* pair = d2i_ECDSA_SIG(nullptr, &der, static_cast<long>(out.size()));
    out = bytes_of(ECDSA_SIG_get0_r(pair), coordinate()) + bytes_of(ECDSA_SIG_get0_s(pair), coordinate());
    ECDSA_SIG_free(pair);
    return out;
  }

  std::unique_ptr<EVP_PKEY, Free> key_;
  std::string type_, name_;
};

/// Making RSA keys takes a while: one for all tests.
const Signer& provider() {
  static const Signer signer = Signer::rsa("key-1");
  return signer;
}

std::string keys(std::initializer_list<json> published) { return json{{"keys", json(published)}}.dump(); }

json claims() {
  return {{"iss", "https://id.example"}, {"aud", "headstock"}, {"exp", kNow + 60}, {"nonce", "n-1"},
          {"sub", "42"},                 {"preferred_username", "li.wei"}, {"name", "李伟"}};
}

Identity identity(const std::string& token, const std::string& key_set) {
  ProviderSettings settings;
  settings.issuer = "https://id.example";
  settings.client_id = "headstock";
  return identity_of(token, key_set, settings, "n-1", kNow);
}

std::string refusal(const std::string& token, const std::string& key_set) {
  try {
    identity(token, key_set);
  } catch (const db::Refusal& refused) {
    EXPECT_EQ(refused.code(), "provider_failed");
    return refused.where();
  }
  return "accepted";
}

TEST(IdentityToken, SignedByThePublishedKeyNamesThePerson) {
  const std::string published = keys({provider().published()});
  for (const char* algorithm : {"RS256", "RS384", "RS512", "PS256", "PS384", "PS512"}) {
    const Identity found = identity(provider().token(claims(), algorithm), published);
    EXPECT_EQ(found.external, "https://id.example#42") << algorithm;
    EXPECT_EQ(found.user, "li.wei");
    EXPECT_EQ(found.name, "李伟");
  }
  const Signer p256 = Signer::ec("e"), p384 = Signer::ec("e", "P-384");
  // Among keys of other kinds and uses, and without a name.
  json encryption = p256.published();
  encryption["use"] = "enc";
  EXPECT_EQ(refusal(p256.token(claims(), "ES256"), keys({encryption, provider().published()})), "key");
  EXPECT_EQ(identity(p256.token(claims(), "ES256"), keys({encryption, provider().published(), p256.published()})).user, "li.wei");
  EXPECT_EQ(identity(p256.token(claims(), "ES256", {{"kid", ""}}), keys({p384.published(), p256.published()})).user, "li.wei");
  EXPECT_EQ(identity(p384.token(claims(), "ES384"), keys({p384.published()})).user, "li.wei");
}

TEST(IdentityToken, AnotherKeyIsNoProof) {
  const Signer stranger = Signer::rsa("key-1"), small = Signer::rsa("key-1", 1024), curve = Signer::ec("key-1");
  const std::string published = keys({provider().published()});
  EXPECT_EQ(refusal(stranger.token(claims(), "RS256"), published), "signature") << "the right name on the wrong key";
  EXPECT_EQ(refusal(stranger.token(claims(), "PS256"), published), "signature");
  EXPECT_EQ(refusal(Signer::ec("key-1").token(claims(), "ES256"), keys({curve.published()})), "signature");
  EXPECT_EQ(refusal(curve.token(claims(), "ES256"), published), "key") << "an elliptic signature under an RSA key";
  EXPECT_EQ(refusal(provider().token(claims(), "RS256", {{"kid", "key-2"}}), published), "key") << "withdrawn or not published";
  EXPECT_EQ(refusal(small.token(claims(), "RS256"), keys({small.published()})), "key") << "too short to be a key";
  EXPECT_EQ(refusal(provider().token(claims(), "RS256"), R"({"keys":[]})"), "key");
  EXPECT_EQ(refusal(provider().token(claims(), "RS256"), "no keys at all"), "keys");
  json only = provider().published();
  only["alg"] = "RS512";
  EXPECT_EQ(refusal(provider().token(claims(), "RS256"), keys({only})), "key") << "published for another algorithm";
  json off_curve = curve.published();
  off_curve["x"] = off_curve["y"];
  EXPECT_NE(refusal(curve.token(claims(), "ES256"), keys({off_curve})), "accepted");
}

TEST(IdentityToken, NoSignatureOrASharedSecretIsRefused) {
  const std::string published = keys({provider().published()});
  const std::string body = encoded(claims().dump());
  for (const char* algorithm : {"none", "None", "NONE", ""}) {
    const std::string bare = encoded(json{{"alg", algorithm}}.dump()) + "." + body + ".";
    EXPECT_EQ(refusal(bare, published), "algorithm") << algorithm;
    EXPECT_EQ(refusal(bare + encoded("x"), published), "algorithm") << algorithm;
  }
  EXPECT_EQ(refusal(encoded("{}") + "." + body + "." + encoded("x"), published), "algorithm") << "says nothing";
  // The public key as if it were a shared secret: everybody has it.
  const std::string secret = provider().published()["n"].get<std::string>();
  const std::string text = encoded(R"({"alg":"HS256","kid":"key-1"})") + "." + body;
  std::string mac(32, '\0');
  unsigned size = 0;
  HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()), reinterpret_cast<const unsigned char*>(text.data()), text.size(),
       reinterpret_cast<unsigned char*>(mac.data()), &size);
  EXPECT_EQ(refusal(text + "." + encoded(mac), published), "algorithm");
  EXPECT_EQ(refusal(encoded(R"({"alg":"RS256"})") + "." + body + ".", published), "signature") << "an empty one";
}

TEST(IdentityToken, AnyChangedCharacterIsRefused) {
  const Signer curve = Signer::ec("e");
  const std::string token = curve.token(claims(), "ES256"), published = keys({curve.published()});
  ASSERT_EQ(refusal(token, published), "accepted");
  // The last character of a piece may carry bits that mean nothing; every other one counts.
  for (std::size_t i = 0; i < token.size(); ++i) {
    if (i + 1 == token.size() || token[i] == '.' || token[i + 1] == '.') continue;
    std::string changed = token;
    changed[i] = changed[i] == 'A' ? 'B' : 'A';
    EXPECT_NE(refusal(changed, published), "accepted") << i;
  }
  json other = claims();
  other["sub"] = "1";
  const auto first = token.find('.'), second = token.find('.', first + 1);
  EXPECT_EQ(refusal(token.substr(0, first + 1) + encoded(other.dump()) + token.substr(second), published), "signature");
  for (const std::string bad : {"", ".", "..", "a.b", "a.b.c.d", "!.!.!"}) EXPECT_NE(refusal(bad, published), "accepted") << bad;
  EXPECT_EQ(refusal(token + ".", published), "token");
  EXPECT_EQ(refusal(curve.token(claims(), "ES256", {{"crit", {"b64"}}}), published), "token") << "demands what is not understood";
}

TEST(IdentityToken, WellSignedButNotForUsNowIsRefused) {
  const std::string published = keys({provider().published()});
  const auto with = [&](const char* name, const json& value) {
    json changed = claims();
    changed[name] = value;
    return refusal(provider().token(changed, "RS256"), published);
  };
  EXPECT_EQ(with("iss", "https://other.example"), "issuer");
  EXPECT_EQ(with("aud", "another"), "audience");
  EXPECT_EQ(with("aud", {"headstock", "another"}), "audience") << "for several, without naming us";
  EXPECT_EQ(with("aud", 7), "audience");
  EXPECT_EQ(with("exp", kNow - 121), "expired");
  EXPECT_EQ(with("exp", kNow - 119), "accepted") << "clocks differ a little";
  EXPECT_EQ(with("exp", "soon"), "expired");
  EXPECT_EQ(with("nonce", "n-2"), "nonce");
  EXPECT_EQ(with("sub", ""), "subject");
  EXPECT_EQ(with("sub", std::string(256, '4')), "subject");
}

}  // namespace
}  // namespace headstock::integrations
