// TLS of the link: version 1.3 only, both sides certified by the shop's CA, ALPN `headstock/1`.
#pragma once

#include <boost/asio/ssl/context.hpp>
#include <string>

#include "protocol/wire/certificates.hpp"

namespace headstock::wire {

/// Accepts agents with a certificate of this CA, and connections without one (they may only enrol).
boost::asio::ssl::context server_context(const Authority& authority);
/// Accepts only a server certified by this CA.
boost::asio::ssl::context agent_context(const std::string& ca_pem, const std::string& certificate_pem,
                                        const std::string& key_pem);
/// For enrolment: the server is checked by `check_enrolment_server` after the handshake, before anything is
/// sent.
boost::asio::ssl::context enrolment_context();

/// The server's chain leads to the CA with this fingerprint. @return empty when it does (and `ca_pem` is that
/// CA), else why not.
std::string check_enrolment_server(SSL* connection, const std::string& ca_fingerprint, std::string& ca_pem);
/// PEM of the other side's certificate, empty when it showed none.
std::string peer_certificate(SSL* connection);
/// Why the other side's certificate was not accepted ("certificate has expired"), empty when that was not the
/// reason.
std::string verification_failure(SSL* connection);

}  // namespace headstock::wire
