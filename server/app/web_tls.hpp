// The certificate of the browser's side.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <boost/asio/ssl/context.hpp>

namespace headstock::app {

/// TLS 1.2 and 1.3 with the given certificate chain and key (PEM files). Throws StartError{tls}.
std::unique_ptr<boost::asio::ssl::context> tls_from_files(const std::filesystem::path& certificate,
                                                          const std::filesystem::path& key);
/// With the server's certificate of the data folder's own CA, for these host names and addresses.
std::unique_ptr<boost::asio::ssl::context> tls_from_pki(const std::filesystem::path& pki_folder,
                                                        const std::vector<std::string>& host_names);
/// Addresses and names by which this computer may be called.
std::vector<std::string> own_names(const std::string& address);

}  // namespace headstock::app
