#include "server/app/shop.hpp"

#include <chrono>
#include <csignal>

#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

#include "db/blobs.hpp"
#include "db/refusal.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "db/user_store.hpp"
#include "protocol/process/log.hpp"
#include "server/access/accounts.hpp"
#include "server/access/view_tokens.hpp"
#include "server/api/events/socket.hpp"
#include "server/api/jobs.hpp"
#include "server/api/http/web_server.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/api/static_files.hpp"
#include "server/app/data_folder.hpp"
#include "generated/version.hpp"
#include "server/app/web_tls.hpp"
#include "server/dnc/dnc.hpp"
#include "server/backup/backups.hpp"
#include "server/fleet/fleet.hpp"
#include "server/fleet/value_requests.hpp"
#include "server/integrations/notifier.hpp"
#include "server/integrations/sign_in_provider.hpp"
#include "server/library/checks.hpp"
#include "server/library/distribution.hpp"
#include "server/library/lines.hpp"

namespace headstock::app {

namespace asio = boost::asio;
using asio::awaitable;
using namespace std::chrono_literals;

namespace {

constexpr auto drain_time = 10s;
constexpr unsigned worker_threads = 2;

bool is_loopback(const std::string& address) {
  boost::system::error_code error;
  const auto parsed = asio::ip::make_address(address, error);
  return !error && parsed.is_loopback();
}

/// What the database says becomes the line the person sees; it is written for that.
template <class F>
auto with_database(F open) {
  try {
    return open();
  } catch (const db::Error& error) {
    const bool in_use = error.problem() == db::Problem::locked;
    throw StartError(in_use ? StartError::data_in_use : StartError::database, error.what());
  }
}

/// For work that runs beside the second's own.
auto logged(const char* what) {
  return [what](std::exception_ptr error) {
    if (!error) return;
    try {
      std::rethrow_exception(error);
    } catch (const std::exception& problem) {
      log::error("{}: {}", what, problem.what());
    }
  };
}

/// A wall screen's secret: the shop as a viewer sees it, and nothing that changes anything.
awaitable<api::Principal> authenticate_screen(db::Store& store, std::string token) {
  const auto row = co_await store.run(
      [&token](db::Database& db) { return access::find_view_token(db, token, db::now_ms()); });
  api::Principal who;
  if (!row) co_return who;
  who.user = "screen:" + std::to_string(row->id);
  who.name = row->name;
  who.language = "en";
  who.role = api::Role::viewer;
  who.look_only = true;
  who.expires_ms = row->expires_ms.value_or(0);
  who.token = std::move(token);
  co_return who;
}

awaitable<api::Principal> authenticate(db::Store& store, std::string token) {
  const auto session = co_await store.run(
      [&token](db::Database& db) { return access::find_session(db, token, db::now_ms()); });
  api::Principal who;
  if (!session) co_return co_await authenticate_screen(store, std::move(token));
  who.rights = session->rights;
  who.user_id = session->user.id;
  who.user = session->user.user;
  who.name = session->user.name;
  who.language = session->user.language;
  who.role = api::role_from(access::to_string(session->user.role));
  who.expires_ms = session->expires_ms;
  who.must_change_password = session->user.must_change_password;
  who.token = std::move(token);
  co_return who;
}

/// Who was signed in a moment ago, so that Stop need not wait for the store.
class Seen {
 public:
  void remember(const std::string& token, const api::Principal& who, std::int64_t now) {
    if (who.role == api::Role::none) {
      people_.erase(token);
      return;
    }
    if (people_.size() >= kMost) people_.clear();
    people_[token] = {who, who.expires_ms == 0 ? now + kFor_ms : std::min(now + kFor_ms, who.expires_ms)};
  }
  std::optional<api::Principal> find(const std::string& token, std::int64_t now) const {
    const auto found = people_.find(token);
    if (found == people_.end() || found->second.until_ms <= now) return std::nullopt;
    return found->second.who;
  }

 private:
  static constexpr std::size_t kMost = 10'000;
  static constexpr std::int64_t kFor_ms = 300'000;
  struct Person {
    api::Principal who;
    std::int64_t until_ms = 0;
  };
  std::map<std::string, Person> people_;
};

}  // namespace

struct Shop::Impl {
  explicit Impl(Options given)
      : options(std::move(given)),
        folder(options.data),
        sign_in_file(options.first_sign_in_file.empty() ? options.data / "first-sign-in" : options.first_sign_in_file),
        store(with_database([&] { return std::make_unique<db::Store>(options.data, options.database); })),
        blobs(with_database([&] { return std::make_unique<db::Blobs>(options.data); })),
        accounts(*store, workers),
        lines(*blobs),
        checks(*store, workers, *blobs),
        fleet(io.get_executor(), *store, changes),
        gateway(io, gateway_options(), fleet),
        values(*store,
               [this](std::int64_t machine, nlohmann::json write) { return gateway.write_data(machine, std::move(write)); },
               [this](std::int64_t machine) { fleet.values_changed(machine); }),
        distributor(io.get_executor(), *store, *blobs, checks, library::carried_by(gateway),
                    [this](const db::TransferRow& row) { publish(row); }),
        dnc(io, *store, workers, *blobs, checks, [this](std::int64_t port) { publish_port(port); }),
        jobs(io),
        notifier(*store, messenger),
        backups(*store, keeper, *blobs, options.data, version()),
        provider(*store, messenger),
        services{io,    *store,      workers, *blobs,  accounts, checks, lines,
                 distributor, fleet, changes, gateway, values, dnc, jobs, notifier, backups, provider, version()} {
    fleet.set_distributor(&distributor);
    dnc.set_agents(agents_as_ports());
    backups.set_restorer({.send = [this](access::Actor actor, std::int64_t program, std::int64_t revision, std::int64_t machine) {
                            return send_restored(std::move(actor), program, revision, machine);
                          },
                          .write = [this](access::Actor actor, std::int64_t machine, std::map<std::string, double> wanted, std::string why) {
                            return write_restored(std::move(actor), machine, std::move(wanted), std::move(why));
                          }});
    api::add_all_routes(router, services);
  }

  server::GatewayOptions gateway_options() const {
    server::GatewayOptions agents;
    agents.address = options.agent_address.empty() ? options.address : options.agent_address;
    agents.port = options.agent_port;
    agents.pki_folder = (options.data / "pki").string();
    return agents;
  }

  awaitable<api::Principal> look_up(std::string token);
  dnc::AgentCarrier agents_as_ports();
  awaitable<nlohmann::json> write_restored(access::Actor actor, std::int64_t machine, std::map<std::string, double> wanted,
                                           std::string why);
  awaitable<nlohmann::json> send_restored(access::Actor actor, std::int64_t program, std::int64_t revision, std::int64_t machine);
  void publish(const db::TransferRow& row);
  void publish_port(std::int64_t port);
  void make_first_administrator();
  void start_web();
  awaitable<void> tick();
  awaitable<void> forget_first_sign_in();
  awaitable<void> drain();
  void begin_stop();

  // In the order in which they need each other; destroyed the other way round.
  Options options;
  DataFolder folder;
  std::filesystem::path sign_in_file;
  fleet::Changes changes;
  asio::io_context io{1};
  std::unique_ptr<db::Store> store;
  db::Pool workers{worker_threads};
  std::unique_ptr<db::Blobs> blobs;
  access::Accounts accounts;
  library::LineReader lines;
  library::Checks checks;
  fleet::Fleet fleet;
  server::Gateway gateway;
  fleet::ValueDesk values;
  library::Distributor distributor;
  dnc::Dnc dnc;
  Seen seen;
  api::Jobs jobs;
  db::Pool messenger{1};   ///< mail servers may be slow; nothing else waits behind them
  db::Pool keeper{1};      ///< backups and retention take minutes
  integrations::Notifier notifier;
  backup::Backups backups;
  integrations::SignInProvider provider;
  api::Services services;
  api::Router router;
  std::unique_ptr<asio::ssl::context> tls;
  std::unique_ptr<api::WebServer> web;
  std::string first_password;
  std::optional<asio::executor_work_guard<asio::io_context::executor_type>> work;
  std::optional<asio::signal_set> signals;
  asio::steady_timer second{io};
  bool stopping = false;
};

awaitable<api::Principal> Shop::Impl::look_up(std::string token) {
  auto who = co_await authenticate(*store, token);
  seen.remember(token, who, db::now_ms());
  co_return who;
}

dnc::AgentCarrier Shop::Impl::agents_as_ports() {
  dnc::AgentCarrier agents;
  agents.is_connected = [this](std::int64_t machine) { return gateway.is_connected(machine); };
  agents.send = [this](access::Actor actor, std::int64_t machine, std::int64_t program, std::int64_t revision,
                       bool drip) -> awaitable<db::TransferRow> {
    if (drip) co_return co_await distributor.drip(std::move(actor), machine, program, revision);
    std::vector<std::int64_t> machines(1, machine);
    auto sent = co_await distributor.distribute(std::move(actor), program, revision, std::move(machines));
    co_return sent.transfers.at(0);
  };
  agents.cancel = [this](access::Actor actor, std::int64_t transfer) {
    return distributor.cancel(std::move(actor), transfer);
  };
  return agents;
}

/// As a person would send it: planned, checked, with a state and a reason.
awaitable<nlohmann::json> Shop::Impl::send_restored(access::Actor actor, std::int64_t program, std::int64_t revision,
                                                    std::int64_t machine) {
  actor.rights = nullptr;   // who may restore a machine may send what is released to it
  actor.role = std::max(actor.role, access::Role::programmer);
  std::vector<std::int64_t> machines = {machine};
  const auto plan = co_await distributor.distribute(std::move(actor), program, revision, std::move(machines));
  const auto id = plan.id;
  const auto first = co_await store->run([id](db::Database& db) {
    return db.integer("SELECT id FROM transfers WHERE distribution_id = ?", {id}).value_or(0);
  });
  const auto transfer = co_await distributor.find(first);
  if (!transfer) co_return nlohmann::json{{"state", "failed"}, {"reason", "not_connected"}};
  co_return nlohmann::json{{"state", transfer->state}, {"reason", transfer->reason}, {"transfer", transfer->id}};
}

/// What differs is asked for as any other change: within the limits of one person, written, read back.
awaitable<nlohmann::json> Shop::Impl::write_restored(access::Actor actor, std::int64_t machine, std::map<std::string, double> wanted,
                                                     std::string why) {
  using nlohmann::json;
  actor.rights = nullptr;   // who may restore a machine may write what belongs to it
  actor.role = std::max(actor.role, access::Role::setter);
  try {
    const auto compare = [&](db::Database& db) { return fleet::difference(db, machine, wanted, ""); };
    fleet::Difference difference = co_await store->run(compare);
    if (difference.items.empty()) co_return json{{"state", "same"}, {"without_place", difference.without_place}};
    fleet::NewValueRequest request;
    request.machine = machine;
    request.origin = "restore";
    request.why = std::move(why);
    const auto count = difference.items.size();
    request.items = std::move(difference.items);
    const auto row = co_await values.ask(std::move(actor), std::move(request));
    co_return json{{"state", row.state},   {"reason", row.reason}, {"where", row.where}, {"request", row.id},
                   {"differ", count}, {"without_place", difference.without_place}};
  } catch (const db::Refusal& refusal) {
    co_return json{{"state", "refused"}, {"reason", refusal.code()}, {"where", refusal.where()}};
  }
}

void Shop::Impl::publish(const db::TransferRow& row) {
  dnc.agent_transfer(row);
  changes.publish({"transfer", row.machine, std::make_shared<const nlohmann::json>(nlohmann::json{{"transfer", api::to_json(row)}})});
}

/// Only that it has changed: who looks at ports asks for what he wants to see.
void Shop::Impl::publish_port(std::int64_t port) {
  changes.publish({"port", 0, std::make_shared<const nlohmann::json>(nlohmann::json{{"port", port}})});
}

void Shop::Impl::make_first_administrator() {
  std::optional<std::string> password;
  store->now([&](db::Database& db) { password = access::ensure_first_administrator(db, db::now_ms()); });
  if (!password) return;
  first_password = *password;
  write_secret(sign_in_file, "user: admin\npassword: " + *password + "\n");
}

void Shop::Impl::start_web() {
  if (options.plain_http && !is_loopback(options.address))
    throw StartError(StartError::tls, "plain HTTP is for loopback only: passwords would cross the network readable on " +
                                          options.address + "; leave out --plain-http, a certificate is made if you have none");
  if (options.tls_certificate.empty() != options.tls_key.empty())
    throw StartError(StartError::usage, "--tls-cert and --tls-key belong together");
  if (!options.tls_certificate.empty())
    tls = tls_from_files(options.tls_certificate, options.tls_key);
  else if (options.tls || !is_loopback(options.address))
    tls = tls_from_pki(options.data / "pki", own_names(options.address));
  api::WebServerOptions web_options;
  web_options.address = options.address;
  web_options.port = options.port;
  web_options.tls = tls.get();
  api::WebHost host;
  host.authenticate = [this](std::string token) { return look_up(std::move(token)); };
  host.known = [this](const std::string& token) { return seen.find(token, db::now_ms()); };
  host.web_socket = [this, look_up_again = host.authenticate](std::shared_ptr<api::SocketClient> client, api::Principal who) {
    return api::serve_events(services, look_up_again, std::move(client), std::move(who));
  };
  host.file = api::static_file;
  host.machines = [this](const api::Route& route, const api::Call& call) { return api::machines_of(services, route, call); };
  web = std::make_unique<api::WebServer>(io, web_options, router, host);
  web->start();
}

/// The written-down password is of use to nobody but a thief once the administrator has chosen another.
awaitable<void> Shop::Impl::forget_first_sign_in() {
  std::error_code ignored;
  if (!std::filesystem::exists(sign_in_file, ignored)) co_return;
  const auto kept = co_await store->run([](db::Database& db) {
    const auto admin = db::user_named(db, "admin");
    return admin && admin->must_change_password;
  });
  if (!kept) std::filesystem::remove(sign_in_file, ignored);
}

awaitable<void> Shop::Impl::tick() {
  for (int seconds = 0; !stopping; ++seconds) {
    second.expires_after(1s);
    co_await second.async_wait(asio::as_tuple(asio::use_awaitable));
    if (stopping) break;
    try {
      fleet.tick();
      if (seconds % 10 == 0) co_await forget_first_sign_in();
      asio::co_spawn(io, notifier.look(), logged("messages"));
      if (seconds % 60 == 30) asio::co_spawn(io, backups.every_minute(), logged("backups and retention"));
    } catch (const std::exception& error) {
      log::error("the second's work failed: {}", error.what());
    }
  }
}

awaitable<void> Shop::Impl::drain() {
  try {
    co_await web->stop(drain_time);
    co_await gateway.shut_down(500ms);
    gateway.stop();
    dnc.stop();
  } catch (const std::exception& error) {
    log::error("stopping: {}", error.what());
  }
  work.reset();
  io.stop();
}

void Shop::Impl::begin_stop() {
  if (stopping) return;
  stopping = true;
  second.cancel();
  if (signals) signals->cancel();
  log::info("stopping: no new connections, finishing what is under way");
  asio::co_spawn(io, drain(), asio::detached);
}

Shop::Shop(Options options) {
  try {
    impl_ = std::make_unique<Impl>(std::move(options));
    impl_->make_first_administrator();
  } catch (const db::Error& error) {
    throw StartError(StartError::database, error.what());
  }
}

Shop::~Shop() = default;

void Shop::start() {
  // Before a machine can ask for it, the gateway must know what it was sending when the last run ended.
  asio::co_spawn(impl_->io, impl_->distributor.resume(), [](std::exception_ptr error) {
    if (error) log::error("transfers of the last run could not be taken up again");
  });
  asio::co_spawn(impl_->io, impl_->dnc.start(), [](std::exception_ptr error) {
    if (error) log::error("the serial ports could not be read");
  });
  impl_->io.run();
  impl_->io.restart();
  try {
    impl_->gateway.start();
    impl_->start_web();
    impl_->dnc.watch_the_clock();
  } catch (const StartError&) {
    throw;
  } catch (const std::exception& error) {
    const std::string text = error.what();
    const bool in_use = text.find("in use") != std::string::npos;
    throw StartError(in_use ? StartError::port_in_use : StartError::other, text);
  }
  impl_->work.emplace(impl_->io.get_executor());
  asio::co_spawn(impl_->io, impl_->tick(), asio::detached);
}

void Shop::run(Signals signals, const std::function<void()>& ready) {
  auto& impl = *impl_;
  if (signals == Signals::watch) {
    impl.signals.emplace(impl.io, SIGTERM, SIGINT);
    impl.signals->async_wait([&impl](const boost::system::error_code& error, int) {
      if (!error) impl.begin_stop();
    });
  }
  ready();
  impl.io.run();
  impl.workers.join();
  impl.messenger.join();
  impl.keeper.join();
}

void Shop::stop() {
  asio::post(impl_->io, [impl = impl_.get()] { impl->begin_stop(); });
}

std::uint16_t Shop::port() const { return impl_->web->port(); }
std::uint16_t Shop::agent_port() const { return impl_->gateway.port(); }
bool Shop::secure() const { return impl_->tls != nullptr; }
const std::string& Shop::first_password() const { return impl_->first_password; }

std::string Shop::url() const {
  const bool six = impl_->options.address.find(':') != std::string::npos;
  return std::string(secure() ? "https://" : "http://") + (six ? "[" : "") + impl_->options.address + (six ? "]" : "") +
         ":" + std::to_string(port());
}

}  // namespace headstock::app
