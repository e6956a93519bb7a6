// Looks every second for alarms that somebody has to hear of, and delivers the messages. Messages survive a restart:
// they wait in the database; one may come twice when the server dies between sending and noting it, never not at all.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <string>

#include "db/database.hpp"
#include "server/access/role.hpp"
#include "server/integrations/deliver.hpp"

namespace headstock::db {
class Store;
class Pool;
}  // namespace headstock::db

namespace headstock::integrations {

struct MessageSettings {
  MailServer mail;
  std::string webhook_secret;
  std::string link;  ///< address of this server as people reach it; goes into the messages
};
/// ---- store thread
MessageSettings message_settings(db::Database& db);
/// Empty password and secret keep the ones that are set. Refusals: forbidden, bad_value.
void set_message_settings(db::Database& db, const access::Actor& actor, const MessageSettings& settings);

class Notifier {
 public:
  /// @param worker one thread of its own: a mail server that does not answer must not hold up checks.
  Notifier(db::Store& store, db::Pool& worker) : store_(store), worker_(worker) {}
  /// One look: new alarms to messages, waiting messages out. Does nothing while an earlier look is still under way.
  boost::asio::awaitable<void> look();
  /// Sends at once. @return empty, or why not.
  boost::asio::awaitable<std::string> try_out(std::string kind, std::string target);

 private:
  db::Store& store_;
  db::Pool& worker_;
  bool busy_ = false;
};

}  // namespace headstock::integrations
