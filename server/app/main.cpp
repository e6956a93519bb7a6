// headstock-server: reads its options, says what it does, serves until it is told to stop.

#include <iostream>

#include "generated/version.hpp"
#include "db/refusal.hpp"
#include "protocol/process/log.hpp"
#include "protocol/process/options.hpp"
#include "server/app/shop.hpp"
#include "server/backup/server_backup.hpp"

namespace {

using headstock::app::Options;
using headstock::app::Shop;
using headstock::app::StartError;

void describe(headstock::options::Program& cli, Options& options, std::string& log_level) {
  cli.version(std::string("headstock-server ") + headstock::app::version());
  cli.option("--data", options.data, "Folder of everything the shop keeps; made if absent").required();
  cli.option("--address", options.address, "IP address to listen on; other than loopback: with TLS").shows_default();
  cli.option("--port", options.port, "Port of browser and API; 0: any free one").shows_default();
  cli.option("--agent-address", options.agent_address, "IP address for the agents (default: --address)");
  cli.option("--agent-port", options.agent_port, "Port for the agents; 0: any free one").shows_default();
  cli.option("--tls-cert", options.tls_certificate, "Certificate chain (PEM) of the browser's side");
  cli.option("--tls-key", options.tls_key, "Its private key (PEM)");
  cli.flag("--tls", options.tls, "TLS on loopback too, with a certificate of the shop's own CA if none is given");
  cli.flag("--plain-http", options.plain_http, "Insist on plain HTTP; refused outside loopback");
  cli.option("--database", options.database,
             "PostgreSQL database instead of SQLite in the data folder: postgresql://user@host/name, or any libpq string")
      .environment("HEADSTOCK_DATABASE");
  cli.option("--initial-admin-file", options.first_sign_in_file,
             "Where to write the first sign-in (default: DATA/first-sign-in)");
  cli.option("--log-level", log_level, "trace, debug, info, warn, error")
      .one_of({"trace", "debug", "info", "warn", "error"})
      .shows_default();
  cli.footer("Exit status: 0 stopped cleanly, 2 usage, 3 port in use, 4 data folder in use, 5 database cannot be used,\n"
             "6 TLS, 1 anything else.");
}

void greet(const Shop& shop, const Options& options) {
  std::cout << "headstock-server " << headstock::app::version() << "\n"
            << "data    " << options.data.string() << "\n"
            << "open    " << shop.url() << "\n"
            << "agents  port " << shop.agent_port() << "\n";
  if (!shop.first_password().empty()) {
    const auto file = options.first_sign_in_file.empty() ? options.data / "first-sign-in" : options.first_sign_in_file;
    std::cout << "sign in with user admin, password " << shop.first_password() << " (shown once; also in "
              << file.string() << " until it is changed)\n";
  }
  std::cout << "ready" << std::endl;
}

}  // namespace

/// `--restore`: fills an empty data folder from a backup and ends.
int restore(const Options& options, const std::filesystem::path& archive) {
  namespace backup = headstock::backup;
  try {
    const auto done = backup::restore_server(archive, options.data, options.database);
    std::cout << "restored the backup of " << done.manifest.value("made", "") << ": " << done.rows << " rows, " << done.programs
              << " program texts into " << options.data.string() << "\nstart the server with the same options, without --restore\n";
    return 0;
  } catch (const headstock::db::Refusal& refusal) {
    const auto* text = headstock::db::refusal_text(refusal.code());
    std::cerr << "headstock-server: " << (text ? text->en : refusal.code()) << " (" << refusal.where() << ")\n";
    return StartError::other;
  } catch (const headstock::db::Error& error) {
    std::cerr << "headstock-server: " << error.what() << "\n";
    return StartError::database;
  }
}

int main(int argc, char** argv) {
  headstock::options::Program cli("Headstock server: programs, machines and the people of one shop");
  Options options;
  std::string log_level = "info";
  std::filesystem::path archive;
  describe(cli, options, log_level);
  cli.option("--restore", archive, "Fill the empty data folder (and database) from this backup of a server, then end")
      .existing_file();
  if (const auto ended = cli.parse(argc, argv, StartError::usage)) return *ended;
  headstock::log::send_to(headstock::log::Target::standard_output);
  headstock::log::leave_out_below(log_level);
  if (!archive.empty()) return restore(options, archive);
  try {
    Shop shop(options);
    shop.start();
    shop.run(Shop::Signals::watch, [&] { greet(shop, options); });
    headstock::log::info("stopped");
    return 0;
  } catch (const StartError& error) {
    std::cerr << "headstock-server: " << error.what() << "\n";
    return error.status();
  } catch (const std::exception& error) {
    std::cerr << "headstock-server: " << error.what() << "\n";
    return StartError::other;
  }
}
