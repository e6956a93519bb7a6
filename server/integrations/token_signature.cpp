#include "server/integrations/token_signature.hpp"

#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ecdsa.h>
#include <openssl/evp.h>
#include <openssl/param_build.h>
#include <openssl/rsa.h>

#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "db/refusal.hpp"

namespace headstock::integrations {
namespace {

using nlohmann::json;

constexpr int kLeastRsaBits = 2048;
constexpr std::size_t kMostKeys = 100;
constexpr unsigned char kUncompressedPoint = 4;

template <auto free>
struct Free {
  template <class T>
  void operator()(T* object) const {
    free(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Free<&EVP_PKEY_free>>;
using KeyContext = std::unique_ptr<EVP_PKEY_CTX, Free<&EVP_PKEY_CTX_free>>;
using Number = std::unique_ptr<BIGNUM, Free<&BN_free>>;

struct Algorithm {
  std::string_view name;
  const char* type;  ///< of the key: "RSA" or "EC"
  const char* digest;
  bool pss;
  std::string_view curve;  ///< as in a key set; empty: RSA
  const char* group;
  std::size_t coordinate_bytes;
};
constexpr std::array<Algorithm, 8> kAlgorithms = {
    {{"RS256", "RSA", "SHA256", false, "", nullptr, 0},
     {"RS384", "RSA", "SHA384", false, "", nullptr, 0},
     {"RS512", "RSA", "SHA512", false, "", nullptr, 0},
     {"PS256", "RSA", "SHA256", true, "", nullptr, 0},
     {"PS384", "RSA", "SHA384", true, "", nullptr, 0},
     {"PS512", "RSA", "SHA512", true, "", nullptr, 0},
     {"ES256", "EC", "SHA256", false, "P-256", "prime256v1", 32},
     {"ES384", "EC", "SHA384", false, "P-384", "secp384r1", 48}}};

[[noreturn]] void failed(const std::string& why) {
  throw db::Refusal("provider_failed", why);
}

std::string text_in(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

const unsigned char* bytes_of(const std::string& text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

Key built(const char* type, OSSL_PARAM_BLD* builder) {
  const std::unique_ptr<OSSL_PARAM, Free<&OSSL_PARAM_free>> parameters(OSSL_PARAM_BLD_to_param(builder));
  const KeyContext context(EVP_PKEY_CTX_new_from_name(nullptr, type, nullptr));
  EVP_PKEY* key = nullptr;
  if (!parameters || !context || EVP_PKEY_fromdata_init(context.get()) != 1 ||
      EVP_PKEY_fromdata(context.get(), &key, EVP_PKEY_PUBLIC_KEY, parameters.get()) != 1)
    return nullptr;
  return Key(key);
}

/// Nothing when it is no key for the algorithm; a key set may hold others.
Key key_for(const Algorithm& algorithm, const json& published) {
  const std::unique_ptr<OSSL_PARAM_BLD, Free<&OSSL_PARAM_BLD_free>> builder(OSSL_PARAM_BLD_new());
  if (algorithm.curve.empty()) {
    const std::string modulus = from_base64_url(text_in(published, "n")),
                      exponent = from_base64_url(text_in(published, "e"));
    const Number n(BN_bin2bn(bytes_of(modulus), static_cast<int>(modulus.size()), nullptr));
    const Number e(BN_bin2bn(bytes_of(exponent), static_cast<int>(exponent.size()), nullptr));
    if (!n || !e || BN_num_bits(n.get()) < kLeastRsaBits) return nullptr;
    OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_N, n.get());
    OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_RSA_E, e.get());
    return built("RSA", builder.get());
  }
  const std::string x = from_base64_url(text_in(published, "x")),
                    y = from_base64_url(text_in(published, "y"));
  if (text_in(published, "crv") != algorithm.curve || x.size() != algorithm.coordinate_bytes ||
      y.size() != x.size())
    return nullptr;
  const std::string point = std::string(1, static_cast<char>(kUncompressedPoint)) + x + y;
  OSSL_PARAM_BLD_push_utf8_string(builder.get(), OSSL_PKEY_PARAM_GROUP_NAME, algorithm.group, 0);
  OSSL_PARAM_BLD_push_octet_string(builder.get(), OSSL_PKEY_PARAM_PUB_KEY, point.data(), point.size());
  return built("EC", builder.get());
}

bool may_sign(const json& published, const Algorithm& algorithm, const std::string& name) {
  if (!published.is_object() || text_in(published, "kty") != algorithm.type) return false;
  const std::string use = text_in(published, "use"), only = text_in(published, "alg");
  return (use.empty() || use == "sig") && (only.empty() || only == algorithm.name) &&
         (name.empty() || text_in(published, "kid") == name);
}

/// Two numbers side by side become the form OpenSSL reads (RFC 7518 3.4).
std::string ecdsa_der(const std::string& pair, std::size_t coordinate_bytes) {
  if (pair.size() != 2 * coordinate_bytes) return {};
  const int length = static_cast<int>(coordinate_bytes);
  Number r(BN_bin2bn(bytes_of(pair), length, nullptr)),
      s(BN_bin2bn(bytes_of(pair) + coordinate_bytes, length, nullptr));
  const std::unique_ptr<ECDSA_SIG, Free<&ECDSA_SIG_free>> signature(ECDSA_SIG_new());
  if (!r || !s || !signature || ECDSA_SIG_set0(signature.get(), r.get(), s.get()) != 1) return {};
  static_cast<void>(r.release()), static_cast<void>(s.release());  // the signature owns them now
  unsigned char* der = nullptr;
  const int size = i2d_ECDSA_SIG(signature.get(), &der);
  if (size <= 0) return {};
  std::string out(reinterpret_cast<const char*>(der), static_cast<std::size_t>(size));
  OPENSSL_free(der);
  return out;
}

bool has_signed(EVP_PKEY* key, const Algorithm& algorithm, const std::string& text,
                const std::string& signature) {
  const std::unique_ptr<EVP_MD_CTX, Free<&EVP_MD_CTX_free>> digest(EVP_MD_CTX_new());
  EVP_PKEY_CTX* context = nullptr;  // the digest's
  if (!digest ||
      EVP_DigestVerifyInit_ex(digest.get(), &context, algorithm.digest, nullptr, nullptr, key, nullptr) != 1)
    return false;
  if (algorithm.pss && (EVP_PKEY_CTX_set_rsa_padding(context, RSA_PKCS1_PSS_PADDING) != 1 ||
                        EVP_PKEY_CTX_set_rsa_pss_saltlen(context, RSA_PSS_SALTLEN_DIGEST) != 1))
    return false;
  return EVP_DigestVerify(digest.get(), bytes_of(signature), signature.size(), bytes_of(text), text.size()) ==
         1;
}

}  // namespace

std::string from_base64_url(const std::string& text) {
  static constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
  if (text.size() % 4 == 1) failed("token");
  std::string out;
  out.reserve(text.size() / 4 * 3 + 2);
  unsigned bits = 0, held = 0;
  for (const char c : text) {
    const auto digit = kAlphabet.find(c);
    if (digit == std::string_view::npos) failed("token");
    bits = ((bits << 6) | static_cast<unsigned>(digit)) & 0xFFFF;
    held += 6;
    if (held < 8) continue;
    held -= 8;
    out += static_cast<char>((bits >> held) & 0xFF);
  }
  return out;
}

void verify_signature(const std::string& token, const std::string& key_set) {
  const auto first = token.find('.'),
             second = first == std::string::npos ? first : token.find('.', first + 1);
  if (second == std::string::npos || token.find('.', second + 1) != std::string::npos) failed("token");
  const json header = json::parse(from_base64_url(token.substr(0, first)), nullptr, false);
  // What a header calls critical must be understood (RFC 7515 4.1.11); there is nothing we do.
  if (!header.is_object() || header.contains("crit")) failed("token");
  const std::string wanted = text_in(header, "alg"), name = text_in(header, "kid");
  const Algorithm* algorithm = nullptr;
  for (const Algorithm& one : kAlgorithms)
    if (one.name == wanted) algorithm = &one;
  if (algorithm == nullptr) failed("algorithm");
  const json published = json::parse(key_set, nullptr, false);
  const auto keys = published.is_object() ? published.find("keys") : published.end();
  if (!published.is_object() || keys == published.end() || !keys->is_array() || keys->size() > kMostKeys)
    failed("keys");

  std::string signature = from_base64_url(token.substr(second + 1));
  if (!algorithm->curve.empty()) signature = ecdsa_der(signature, algorithm->coordinate_bytes);
  if (signature.empty()) failed("signature");
  const std::string text = token.substr(0, second);
  bool one_fits = false;
  for (const json& one : *keys) {
    if (!may_sign(one, *algorithm, name)) continue;
    const Key key = key_for(*algorithm, one);
    if (!key) continue;
    one_fits = true;
    if (has_signed(key.get(), *algorithm, text, signature)) return;
  }
  failed(one_fits ? "signature" : "key");
}

}  // namespace headstock::integrations
