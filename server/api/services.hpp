// What the routes work with. All of it belongs to server/app and outlives the server.
#pragma once

#include <string>

#include <boost/asio/io_context.hpp>

namespace headstock::db {
class Store;
class Pool;
class Blobs;
}  // namespace headstock::db
namespace headstock::access {
class Accounts;
}
namespace headstock::library {
class Checks;
class LineReader;
class Distributor;
}  // namespace headstock::library
namespace headstock::fleet {
class Fleet;
class Changes;
class ValueDesk;
}  // namespace headstock::fleet
namespace headstock::server {
class Gateway;
}

namespace headstock::integrations {
class Notifier;
class SignInProvider;
}
namespace headstock::backup {
class Backups;
}

namespace headstock::dnc {
class Dnc;
}

namespace headstock::api {

class Jobs;

struct Services {
  boost::asio::io_context& io;
  db::Store& store;
  db::Pool& workers;
  db::Blobs& blobs;
  access::Accounts& accounts;
  library::Checks& checks;
  library::LineReader& lines;
  library::Distributor& distributor;
  fleet::Fleet& fleet;
  fleet::Changes& changes;
  server::Gateway& gateway;
  fleet::ValueDesk& values;
  dnc::Dnc& dnc;
  Jobs& jobs;
  integrations::Notifier& notifier;
  backup::Backups& backups;
  integrations::SignInProvider& provider;
  std::string version;
};

}  // namespace headstock::api
