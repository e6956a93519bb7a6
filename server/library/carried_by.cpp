#include "server/library/distribution.hpp"

namespace headstock::library {

Carrier carried_by(server::Gateway& gateway) {
  return {[&gateway](std::int64_t machine) { return gateway.is_connected(machine); },
          [&gateway](std::uint64_t transfer, std::int64_t machine, std::string name, std::string sha256,
                     std::shared_ptr<server::BlobReader> content) {
            return gateway.put(transfer, machine, std::move(name), std::move(sha256), std::move(content));
          },
          [&gateway](std::uint64_t transfer, std::int64_t machine, std::string name, std::string sha256,
                     std::shared_ptr<server::BlobReader> content) {
            return gateway.drip(transfer, machine, std::move(name), std::move(sha256), std::move(content));
          },
          [&gateway](std::uint64_t transfer, std::int64_t machine, std::string name, std::string sha256,
                     std::shared_ptr<server::BlobReader> content) {
            gateway.offer_again(transfer, machine, std::move(name), std::move(sha256), std::move(content));
          },
          [&gateway](std::uint64_t transfer, const std::string& reason) {
            return gateway.cancel(transfer, reason);
          }};
}

}  // namespace headstock::library
