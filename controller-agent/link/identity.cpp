#include "link/identity.hpp"

#include <system_error>
#include <utility>
#include <vector>

namespace headstock::link {
namespace {

std::string joined(const Credentials& c) {
  return c.key_pem + c.certificate_pem + c.ca_pem;
}

/// Key, certificate, CA in this order. @return nullopt for anything else.
std::optional<Credentials> split(const std::string& text) {
  std::vector<std::string> blocks;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = text.find("-----END ", from);
    if (end == std::string::npos) break;
    std::size_t line = text.find('\n', end);
    line = line == std::string::npos ? text.size() : line + 1;
    blocks.push_back(text.substr(from, line - from));
    from = line;
  }
  if (blocks.size() != 3) return std::nullopt;
  return Credentials{blocks[0], blocks[1], blocks[2]};
}

std::optional<Credentials> load(const std::filesystem::path& file) {
  const auto text = wire::read_small_file(file);
  if (!text) return std::nullopt;
  auto credentials = split(*text);
  if (!credentials)
    throw wire::CertificateError(file.string() +
                                 ": not a key with its certificates; restore it or enrol again");
  try {
    (void)wire::read_certificate(credentials->certificate_pem);
    (void)wire::read_certificate(credentials->ca_pem);
  } catch (const wire::CertificateError& bad) {
    throw wire::CertificateError(file.string() + ": " + bad.what() + "; restore it or enrol again");
  }
  return credentials;
}

}  // namespace

Identity::Identity(std::filesystem::path folder)
    : current_file_(folder / "agent.pem"), next_file_(folder / "agent.next.pem") {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw wire::CertificateError(folder.string() + ": cannot be made: " + error.message());
  current_ = load(current_file_);
  next_ = load(next_file_);
}

void Identity::store(const Credentials& credentials) {
  drop_renewed();
  wire::write_private_file(current_file_, joined(credentials));
  current_ = credentials;
}

void Identity::store_renewed(const Credentials& credentials) {
  wire::write_private_file(next_file_, joined(credentials));
  next_ = credentials;
}

void Identity::keep_renewed() {
  if (!next_) return;
  std::filesystem::rename(next_file_, current_file_);
  current_ = std::exchange(next_, std::nullopt);
}

void Identity::drop_renewed() {
  std::error_code ignored;
  std::filesystem::remove(next_file_, ignored);
  next_.reset();
}

}  // namespace headstock::link
