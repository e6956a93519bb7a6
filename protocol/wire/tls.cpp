#include "protocol/wire/tls.hpp"

#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <boost/asio/buffer.hpp>
#include <memory>
#include <string_view>

namespace headstock::wire {
namespace {

namespace ssl = boost::asio::ssl;

constexpr unsigned char kAlpn[] = "\x0bheadstock/1";
constexpr unsigned int kAlpnBytes = sizeof kAlpn - 1;

int select_alpn(SSL*, const unsigned char** out, unsigned char* out_size, const unsigned char* in,
                unsigned int in_size, void*) {
  unsigned char* selected = nullptr;
  if (SSL_select_next_proto(&selected, out_size, kAlpn, kAlpnBytes, in, in_size) != OPENSSL_NPN_NEGOTIATED)
    return SSL_TLSEXT_ERR_ALERT_FATAL;
  *out = selected;
  return SSL_TLSEXT_ERR_OK;
}

ssl::context tls13(ssl::context::method method) {
  ssl::context context(method);
  SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_3_VERSION);
  // A resumed session would skip the look at the certificate: a revoked agent must not come back by a ticket.
  SSL_CTX_set_options(context.native_handle(), SSL_OP_NO_TICKET);
  SSL_CTX_set_num_tickets(context.native_handle(), 0);
  SSL_CTX_set_session_cache_mode(context.native_handle(), SSL_SESS_CACHE_OFF);
  SSL_CTX_set_mode(context.native_handle(), SSL_MODE_RELEASE_BUFFERS);
  return context;
}

void use(ssl::context& context, const std::string& certificate_pem, const std::string& key_pem) {
  context.use_certificate(boost::asio::buffer(certificate_pem), ssl::context::pem);
  context.use_private_key(boost::asio::buffer(key_pem), ssl::context::pem);
}

struct FreeStore {
  void operator()(X509_STORE* store) const { X509_STORE_free(store); }
  void operator()(X509_STORE_CTX* context) const { X509_STORE_CTX_free(context); }
  void operator()(BIO* bio) const { BIO_free_all(bio); }
  void operator()(X509* certificate) const { X509_free(certificate); }
};

std::string peer_pem(X509* certificate) {
  const std::unique_ptr<BIO, FreeStore> bio(BIO_new(BIO_s_mem()));
  if (!bio || PEM_write_bio_X509(bio.get(), certificate) != 1) return {};
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

}  // namespace

ssl::context server_context(const Authority& authority) {
  ssl::context context = tls13(ssl::context::tls_server);
  use(context, authority.server_pem() + authority.ca_pem(), authority.server_key_pem());
  context.use_certificate_chain(boost::asio::buffer(authority.server_pem() + authority.ca_pem()));
  context.add_certificate_authority(boost::asio::buffer(authority.ca_pem()));
  context.set_verify_mode(ssl::verify_peer);
  SSL_CTX_set_alpn_select_cb(context.native_handle(), select_alpn, nullptr);
  return context;
}

ssl::context agent_context(const std::string& ca_pem, const std::string& certificate_pem,
                           const std::string& key_pem) {
  ssl::context context = tls13(ssl::context::tls_client);
  use(context, certificate_pem, key_pem);
  context.add_certificate_authority(boost::asio::buffer(ca_pem));
  context.set_verify_mode(ssl::verify_peer);
  SSL_CTX_set_alpn_protos(context.native_handle(), kAlpn, kAlpnBytes);
  return context;
}

ssl::context enrolment_context() {
  ssl::context context = tls13(ssl::context::tls_client);
  context.set_verify_mode(ssl::verify_none);
  SSL_CTX_set_alpn_protos(context.native_handle(), kAlpn, kAlpnBytes);
  return context;
}

std::string check_enrolment_server(SSL* connection, const std::string& ca_fingerprint, std::string& ca_pem) {
  STACK_OF(X509)* chain = SSL_get_peer_cert_chain(connection);
  if (!chain || sk_X509_num(chain) < 1) return "the server shows no certificate";
  for (int i = 0; i < sk_X509_num(chain); ++i) {
    X509* const candidate = sk_X509_value(chain, i);
    const std::string pem = peer_pem(candidate);
    if (pem.empty() || fingerprint(pem) != ca_fingerprint) continue;
    const std::unique_ptr<X509_STORE, FreeStore> store(X509_STORE_new());
    const std::unique_ptr<X509_STORE_CTX, FreeStore> check(X509_STORE_CTX_new());
    if (!store || !check || X509_STORE_add_cert(store.get(), candidate) != 1 ||
        X509_STORE_CTX_init(check.get(), store.get(), sk_X509_value(chain, 0), nullptr) != 1 ||
        X509_STORE_CTX_set_purpose(check.get(), X509_PURPOSE_SSL_SERVER) != 1)
      return "the server's certificate cannot be checked";
    if (X509_verify_cert(check.get()) != 1)
      return X509_verify_cert_error_string(X509_STORE_CTX_get_error(check.get()));
    ca_pem = pem;
    return {};
  }
  return "the server is not the one that made this token (its authority has another fingerprint)";
}

std::string peer_certificate(SSL* connection) {
  const std::unique_ptr<X509, FreeStore> certificate(SSL_get1_peer_certificate(connection));
  return certificate ? peer_pem(certificate.get()) : std::string();
}

std::string verification_failure(SSL* connection) {
  const long result = SSL_get_verify_result(connection);
  return result == X509_V_OK ? std::string() : X509_verify_cert_error_string(result);
}

}  // namespace headstock::wire
