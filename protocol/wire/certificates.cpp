#include "protocol/wire/certificates.hpp"

#include <fcntl.h>
#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>
#include <fstream>
#include <set>
#include <sstream>

#include "protocol/wire/digest.hpp"

namespace headstock::wire {
namespace {

constexpr std::int64_t kDay = 86'400;
constexpr std::int64_t kCaDays = 20 * 365, kServerDays = 2 * 365, kAgentDays = 365;
/// Clocks of machines are often a little behind.
constexpr std::int64_t kBackdate = kDay;
constexpr std::string_view kAgentPrefix = "agent-";

template <auto Free>
struct Freed {
  template <class T>
  void operator()(T* object) const {
    Free(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Request = std::unique_ptr<X509_REQ, Freed<X509_REQ_free>>;
using Bio = std::unique_ptr<BIO, Freed<BIO_free_all>>;
using Number = std::unique_ptr<BIGNUM, Freed<BN_free>>;
using Extension = std::unique_ptr<X509_EXTENSION, Freed<X509_EXTENSION_free>>;

[[noreturn]] void fail(const std::string& what) {
  char detail[256] = "";
  if (const unsigned long code = ERR_get_error()) ERR_error_string_n(code, detail, sizeof detail);
  ERR_clear_error();
  throw CertificateError(what + (*detail ? std::string(": ") + detail : ""));
}
void require(bool ok, const char* what) {
  if (!ok) fail(what);
}

std::string contents(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<std::size_t>(size)};
}
Bio memory(std::string_view text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

std::string to_pem(X509* certificate) {
  const Bio bio(BIO_new(BIO_s_mem()));
  require(PEM_write_bio_X509(bio.get(), certificate) == 1, "certificate cannot be written");
  return contents(bio.get());
}
std::string to_pem(EVP_PKEY* key) {
  const Bio bio(BIO_new(BIO_s_mem()));
  require(PEM_write_bio_PrivateKey(bio.get(), key, nullptr, nullptr, 0, nullptr, nullptr) == 1,
          "key cannot be written");
  return contents(bio.get());
}
Certificate certificate_from(std::string_view pem) {
  Certificate certificate(PEM_read_bio_X509(memory(pem).get(), nullptr, nullptr, nullptr));
  if (!certificate) fail("not a certificate");
  return certificate;
}
Key key_from(std::string_view pem) {
  Key key(PEM_read_bio_PrivateKey(memory(pem).get(), nullptr, nullptr, nullptr));
  if (!key) fail("not a private key");
  return key;
}
Key make_key() {
  Key key(EVP_EC_gen("P-256"));
  require(key != nullptr, "no key could be made");
  return key;
}

std::string name_of(const X509_NAME* name) {
  char text[256] = "";
  const int size = X509_NAME_get_text_by_NID(const_cast<X509_NAME*>(name), NID_commonName, text, sizeof text);
  return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : std::string();
}
void set_name(X509_NAME* name, const std::string& common_name) {
  require(X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8,
                                     reinterpret_cast<const unsigned char*>(common_name.data()),
                                     static_cast<int>(common_name.size()), -1, 0) == 1,
          "name of a certificate");
}
void add_extension(X509* certificate, X509* issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  const Extension extension(X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str()));
  require(extension && X509_add_ext(certificate, extension.get(), -1) == 1, "extension of a certificate");
}
std::string serial_of(const X509* certificate) {
  const Number number(ASN1_INTEGER_to_BN(X509_get0_serialNumber(certificate), nullptr));
  char* hex = BN_bn2hex(number.get());
  std::string text = hex ? hex : "";
  OPENSSL_free(hex);
  for (char& c : text) c = static_cast<char>(c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c);
  return text;
}
std::int64_t unix_time(const ASN1_TIME* time) {
  std::tm parts{};
  require(ASN1_TIME_to_tm(time, &parts) == 1, "time in a certificate");
  return static_cast<std::int64_t>(timegm(&parts));
}

struct Purpose {
  std::string common_name, basic_constraints, key_usage, extended_usage, alternative_names;
  Validity validity;
};

Certificate make_certificate(EVP_PKEY* subject_key, const Purpose& purpose, X509* issuer,
                             EVP_PKEY* issuer_key) {
  Certificate certificate(X509_new());
  require(certificate != nullptr, "no certificate could be made");
  X509* const made = certificate.get();
  X509* const signer = issuer ? issuer : made;
  require(X509_set_version(made, X509_VERSION_3) == 1, "version of a certificate");
  const Number serial(BN_new());
  // 127 random bits with the top one set: unique without a counter on disk, and of one length.
  require(BN_rand(serial.get(), 127, BN_RAND_TOP_ONE, BN_RAND_BOTTOM_ANY) == 1 &&
              BN_to_ASN1_INTEGER(serial.get(), X509_get_serialNumber(made)) != nullptr,
          "serial number of a certificate");
  require(ASN1_TIME_set(X509_getm_notBefore(made), purpose.validity.not_before_s) != nullptr &&
              ASN1_TIME_set(X509_getm_notAfter(made), purpose.validity.not_after_s) != nullptr,
          "validity of a certificate");
  set_name(X509_get_subject_name(made), purpose.common_name);
  require(X509_set_issuer_name(made, X509_get_subject_name(signer)) == 1, "issuer of a certificate");
  require(X509_set_pubkey(made, subject_key) == 1, "public key of a certificate");
  add_extension(made, signer, NID_basic_constraints, purpose.basic_constraints);
  add_extension(made, signer, NID_key_usage, purpose.key_usage);
  add_extension(made, signer, NID_subject_key_identifier, "hash");
  if (issuer) add_extension(made, signer, NID_authority_key_identifier, "keyid:always");
  if (!purpose.extended_usage.empty()) add_extension(made, signer, NID_ext_key_usage, purpose.extended_usage);
  if (!purpose.alternative_names.empty())
    add_extension(made, signer, NID_subject_alt_name, purpose.alternative_names);
  require(X509_sign(made, issuer_key ? issuer_key : subject_key, EVP_sha256()) > 0,
          "signature of a certificate");
  return certificate;
}

Validity from_now(std::int64_t days) {
  const auto now = static_cast<std::int64_t>(std::time(nullptr));
  return {now - kBackdate, now + days * kDay};
}

bool is_address(const std::string& name) {
  ASN1_OCTET_STRING* address = a2i_IPADDRESS(name.c_str());
  ASN1_OCTET_STRING_free(address);
  return address != nullptr;
}

/// Letters, digits, '-', '.', ':' only: the text goes into OpenSSL's configuration syntax.
bool is_plain_name(const std::string& name) {
  return !name.empty() && name.size() <= 253 && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) || c == '-' || c == '.' || c == ':' || c == '_';
  });
}

std::string alternative_names(const std::vector<std::string>& host_names) {
  std::set<std::string> names = {"DNS:localhost", "IP:127.0.0.1", "IP:::1"};
  char host[256] = "";
  if (::gethostname(host, sizeof host - 1) == 0 && is_plain_name(host))
    names.insert(std::string("DNS:") + host);
  for (const std::string& name : host_names) {
    if (!is_plain_name(name)) throw CertificateError("'" + name + "' is not a host name or address");
    names.insert((is_address(name) ? "IP:" : "DNS:") + name);
  }
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ",") + name;
  return list;
}

}  // namespace

CertificateInfo read_certificate(std::string_view pem) {
  const Certificate certificate = certificate_from(pem);
  return {name_of(X509_get_subject_name(certificate.get())), serial_of(certificate.get()),
          unix_time(X509_get0_notBefore(certificate.get())),
          unix_time(X509_get0_notAfter(certificate.get()))};
}

bool due_for_renewal(const CertificateInfo& certificate, std::int64_t now_s) {
  return now_s >= certificate.not_after_s - (certificate.not_after_s - certificate.not_before_s) / 3;
}

std::string fingerprint(std::string_view pem) {
  const Certificate certificate = certificate_from(pem);
  std::array<unsigned char, 32> digest{};
  unsigned int size = 0;
  require(X509_digest(certificate.get(), EVP_sha256(), digest.data(), &size) == 1,
          "fingerprint of a certificate");
  return to_hex(digest);
}

std::int64_t machine_of_name(std::string_view common_name) {
  if (!common_name.starts_with(kAgentPrefix)) return 0;
  common_name.remove_prefix(kAgentPrefix.size());
  std::int64_t machine = 0;
  const char* last = common_name.data() + common_name.size();
  const auto [end, error] = std::from_chars(common_name.data(), last, machine);
  return error == std::errc{} && end == last && machine > 0 ? machine : 0;
}

KeyAndRequest make_key_and_request(const std::string& common_name) {
  const Key key = make_key();
  const Request request(X509_REQ_new());
  require(request && X509_REQ_set_version(request.get(), X509_REQ_VERSION_1) == 1,
          "no request could be made");
  set_name(X509_REQ_get_subject_name(request.get()), common_name);
  require(X509_REQ_set_pubkey(request.get(), key.get()) == 1, "public key of a request");
  require(X509_REQ_sign(request.get(), key.get(), EVP_sha256()) > 0, "signature of a request");
  const Bio bio(BIO_new(BIO_s_mem()));
  require(PEM_write_bio_X509_REQ(bio.get(), request.get()) == 1, "request cannot be written");
  return {to_pem(key.get()), contents(bio.get())};
}

std::string make_secret() {
  return random_hex(16);
}

std::string format_token(const EnrolmentToken& token) {
  return "HS1-" + token.secret + "-" + token.ca_fingerprint;
}

std::optional<EnrolmentToken> parse_token(std::string_view text) {
  const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  if (!text.starts_with("HS1-")) return std::nullopt;
  text.remove_prefix(4);
  const auto dash = text.find('-');
  if (dash == std::string_view::npos || dash < 16 || dash > 128) return std::nullopt;
  EnrolmentToken token{std::string(text.substr(0, dash)), std::string(text.substr(dash + 1))};
  const bool sound = std::ranges::all_of(token.secret, [](unsigned char c) { return std::isalnum(c); });
  if (!sound || !is_sha256_hex(token.ca_fingerprint)) return std::nullopt;
  return token;
}

void write_private_file(const std::filesystem::path& path, std::string_view text) {
  std::filesystem::path temporary = path;
  temporary += ".new";
  const auto complain = [&] {
    throw CertificateError(path.string() + ": cannot be written: " + std::strerror(errno));
  };
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0) complain();
  bool written = true;
  for (std::string_view left = text; written && !left.empty();) {
    const ssize_t count = ::write(file, left.data(), left.size());
    if (count < 0)
      written = errno == EINTR;
    else
      left.remove_prefix(static_cast<std::size_t>(count));
  }
  written = written && ::fsync(file) == 0;
  ::close(file);
  if (!written || ::rename(temporary.c_str(), path.c_str()) != 0) complain();
  const int folder = ::open(path.parent_path().empty() ? "." : path.parent_path().c_str(),
                            O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder >= 0) {
    ::fsync(folder);
    ::close(folder);
  }
}

std::optional<std::string> read_small_file(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw CertificateError(path.string() + ": cannot be read");
  return text.str();
}

struct Authority::Impl {
  Key ca_key;
  Certificate ca;
  std::string ca_pem, ca_fingerprint, server_pem, server_key_pem;
};

Authority::Authority(const std::filesystem::path& folder, const std::vector<std::string>& host_names)
    : impl_(std::make_unique<Impl>()) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw CertificateError(folder.string() + ": cannot be made: " + error.message());
  const auto ca_key_file = folder / "ca.key", ca_file = folder / "ca.pem";
  const auto server_key_file = folder / "server.key", server_file = folder / "server.pem",
             names_file = folder / "server.names";

  auto ca_key_pem = read_small_file(ca_key_file);
  auto ca_pem = read_small_file(ca_file);
  if (!ca_pem) {
    // The certificate is written last: a key without it is what a cut first start left, and nobody was
    // enrolled with it.
    const Key key = make_key();
    const Certificate ca = make_certificate(key.get(),
                                            {"Headstock CA " + random_hex(4), "critical,CA:TRUE,pathlen:0",
                                             "critical,keyCertSign,cRLSign", "", "", from_now(kCaDays)},
                                            nullptr, nullptr);
    ca_key_pem = to_pem(key.get());
    ca_pem = to_pem(ca.get());
    write_private_file(ca_key_file, *ca_key_pem);
    write_private_file(ca_file, *ca_pem);
  }
  if (!ca_key_pem)
    throw CertificateError(ca_key_file.string() +
                           ": the key of the certificate authority is missing; restore it from a backup");
  try {
    impl_->ca_key = key_from(*ca_key_pem);
    impl_->ca = certificate_from(*ca_pem);
  } catch (const CertificateError& bad) {
    throw CertificateError(folder.string() + ": the certificate authority cannot be read: " + bad.what());
  }
  if (X509_check_private_key(impl_->ca.get(), impl_->ca_key.get()) != 1)
    throw CertificateError(folder.string() + ": ca.key does not belong to ca.pem");
  impl_->ca_pem = *ca_pem;
  impl_->ca_fingerprint = fingerprint(*ca_pem);

  const std::string names = alternative_names(host_names);
  auto server_pem = read_small_file(server_file);
  auto server_key_pem = read_small_file(server_key_file);
  bool sound = server_pem && server_key_pem && read_small_file(names_file) == names;
  if (sound) {
    try {
      const Certificate server = certificate_from(*server_pem);
      const Key key = key_from(*server_key_pem);
      sound = X509_check_private_key(server.get(), key.get()) == 1 &&
              X509_verify(server.get(), impl_->ca_key.get()) == 1 &&
              !due_for_renewal(read_certificate(*server_pem), static_cast<std::int64_t>(std::time(nullptr)));
    } catch (const CertificateError&) {
      sound = false;  // made again below: unlike the CA, nothing depends on this very certificate
    }
    ERR_clear_error();
  }
  if (!sound) {
    const Key key = make_key();
    const Certificate server =
        make_certificate(key.get(),
                         {"headstock-server", "critical,CA:FALSE", "critical,digitalSignature", "serverAuth",
                          names, from_now(kServerDays)},
                         impl_->ca.get(), impl_->ca_key.get());
    server_key_pem = to_pem(key.get());
    server_pem = to_pem(server.get());
    write_private_file(server_key_file, *server_key_pem);
    write_private_file(server_file, *server_pem);
    write_private_file(names_file, names);
  }
  impl_->server_pem = *server_pem;
  impl_->server_key_pem = *server_key_pem;
}

Authority::~Authority() = default;
Authority::Authority(Authority&&) noexcept = default;
Authority& Authority::operator=(Authority&&) noexcept = default;
const std::string& Authority::ca_pem() const {
  return impl_->ca_pem;
}
const std::string& Authority::server_pem() const {
  return impl_->server_pem;
}
const std::string& Authority::server_key_pem() const {
  return impl_->server_key_pem;
}
const std::string& Authority::ca_fingerprint() const {
  return impl_->ca_fingerprint;
}

IssuedCertificate Authority::sign(std::string_view request_pem, std::int64_t machine,
                                  std::optional<Validity> validity) const {
  const Request request(PEM_read_bio_X509_REQ(memory(request_pem).get(), nullptr, nullptr, nullptr));
  if (!request) fail("not a certificate request");
  EVP_PKEY* const key = X509_REQ_get0_pubkey(request.get());
  char group[32] = "";
  const bool p256 = key && EVP_PKEY_get_base_id(key) == EVP_PKEY_EC &&
                    EVP_PKEY_get_group_name(key, group, sizeof group, nullptr) == 1 &&
                    std::strcmp(group, "prime256v1") == 0;
  if (!p256) fail("the key of a request must be P-256");
  if (X509_REQ_verify(request.get(), key) != 1) fail("the signature of the request is wrong");
  const Certificate made = make_certificate(
      key,
      {std::string(kAgentPrefix) + std::to_string(machine), "critical,CA:FALSE", "critical,digitalSignature",
       "clientAuth", "", validity.value_or(from_now(kAgentDays))},
      impl_->ca.get(), impl_->ca_key.get());
  return {to_pem(made.get()), serial_of(made.get())};
}

}  // namespace headstock::wire
