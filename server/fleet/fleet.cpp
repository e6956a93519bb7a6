#include "server/fleet/fleet.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "db/hash.hpp"
#include "db/program_store.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "machine/machine.hpp"
#include "protocol/process/log.hpp"
#include "server/access/audit.hpp"
#include "server/fleet/events.hpp"
#include "server/fleet/live_table.hpp"
#include "server/fleet/machines.hpp"
#include "server/fleet/states.hpp"
#include "server/fleet/value_requests.hpp"
#include "server/fleet/values.hpp"
#include "server/library/distribution.hpp"

namespace headstock::fleet {

namespace asio = boost::asio;
using nlohmann::json;

namespace {

/// The last live state and sign of life go to the store so seldom: a restart may lose that much, a disk is
/// not worn out.
constexpr std::int64_t kSaveEveryMs = 10'000;
/// At most this often a watcher hears of one machine.
constexpr std::int64_t kPublishEveryMs = 200;

/// What is read at the start, and again when people have changed something.
struct Picture {
  std::vector<db::MachineRow> machines;
  std::map<std::int64_t, std::vector<db::AlarmRow>> alarms;
  std::map<std::string, KnownProgram> programs;
};

Picture read_picture(db::Database& db) {
  Picture picture;
  picture.machines = db::machines(db);
  for (const db::MachineRow& machine : picture.machines) {
    db::AlarmFilter filter;
    filter.machine = machine.id;
    filter.active_only = true;
    auto active = db::alarms(db, filter, {0, 100}).items;
    std::ranges::reverse(active);
    picture.alarms[machine.id] = std::move(active);
  }
  // Oldest first, so that the newest wins; then the released ones over all.
  for (const char* rest : {"WHERE l.id IS NULL", "WHERE l.id IS NOT NULL"})
    db.each(std::string("SELECT v.sha256, v.program_id, v.number, l.id FROM revisions v JOIN programs p ON "
                        "p.id = v.program_id AND "
                        "p.removed_ms IS NULL LEFT JOIN releases l ON l.program_id = v.program_id AND "
                        "l.revision = v.number AND "
                        "l.withdrawn_ms IS NULL ") +
                rest + " ORDER BY v.at_ms",
            {}, [&](const db::Row& row) {
              picture.programs[row.text(0)] = {row.integer(1), row.integer(2), !row.is_null(3)};
            });
  return picture;
}

json parse_or_null(const std::string& text) {
  return text.empty() ? json(nullptr) : json::parse(text, nullptr, false);
}

std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// The machine file that the agent runs with is what programs are checked against. @return did it change?
bool adopt_machine_file(db::Database& db, std::int64_t machine, const json& hello) {
  const auto row = db::machine(db, machine);
  const std::string toml = text_of(hello, "machine_toml");
  if (!row || toml.empty() || toml == row->toml) return false;
  if (std::holds_alternative<machine::MachineError>(machine::parse_machine(toml, "machine", row->profile))) {
    log::warning("machine {}: the agent's machine file does not fit its profile {}", machine, row->profile);
    return false;
  }
  db::MachineRow changed = *row;
  changed.toml = toml;
  changed.config_hash = config_hash(changed.profile, toml);
  db::update_machine(db, changed);
  access::record(db, access::Actor{}, "machine.reported",
                 std::string("machine:").append(std::to_string(machine)), {{"config", changed.config_hash}});
  return true;
}

}  // namespace

struct Fleet::Impl {
  Impl(asio::any_io_executor the_network, db::Store& the_store, Changes& the_changes)
      : network(std::move(the_network)), store(the_store), changes(the_changes) {}

  void apply(const Picture& picture) {
    std::map<std::int64_t, Entry> next;
    for (const db::MachineRow& machine : picture.machines) {
      auto old = entries.extract(machine.id);
      Entry& entry = next[machine.id];
      if (old) {
        entry = std::move(old.mapped());
      } else {
        entry.live = parse_or_null(machine.live_json);
        if (entry.live.is_object()) entry.received_ms = machine.last_seen_ms;
      }
      entry.machine = machine;
      const auto alarms = picture.alarms.find(machine.id);
      if (alarms != picture.alarms.end()) entry.alarms = alarms->second;
    }
    entries = std::move(next);
    programs = picture.programs;
  }

  Entry* find(std::int64_t machine) {
    const auto found = entries.find(machine);
    return found == entries.end() ? nullptr : &found->second;
  }

  void publish(Entry& entry, std::int64_t now) {
    entry.published_ms = now;
    changes.publish_live(entry.machine.id, std::make_shared<const json>(live_json(entry, programs, now)));
  }

  void publish_soon(Entry& entry, std::int64_t now) {
    if (now - entry.published_ms >= kPublishEveryMs) publish(entry, now);
  }

  void save(Entry& entry, std::int64_t now) {
    entry.saved_ms = now;
    json kept = entry.live;
    if (kept.is_object()) kept.erase("trail");
    store.post("live", [id = entry.machine.id, heard = entry.heard_ms,
                        text = kept.is_object() ? kept.dump(-1, ' ', false, json::error_handler_t::replace)
                                                : std::string()](db::Database& db) {
      db.execute("UPDATE machines SET last_seen_ms = ?, live_json = ? WHERE id = ?", {heard, text, id});
    });
  }

  /// Back on the network thread with something to do there.
  template <class Work>
  void on_network(Work work) {
    asio::post(network, [alive = std::weak_ptr<int>(life), work = std::move(work)]() mutable {
      if (alive.lock()) work();
    });
  }

  void tell(const Intake& intake, std::int64_t machine) {
    const auto publish_piece = [&](const char* topic, json body) {
      changes.publish({topic, machine, std::make_shared<const json>(std::move(body))});
    };
    for (const db::PartRow& part : intake.parts) publish_piece("part", part_json(part));
    for (const db::AlarmRow& alarm : intake.raised) publish_piece("alarm", alarm_json(alarm));
    for (const db::AlarmRow& alarm : intake.cleared) publish_piece("alarm", alarm_json(alarm));
    for (const std::string& complaint : intake.complaints)
      log::warning("machine {}: event {}", machine, complaint);
    Entry* entry = find(machine);
    if (entry == nullptr) return;
    for (const db::AlarmRow& alarm : intake.raised) entry->alarms.push_back(alarm);
    drop_cleared(*entry, intake.cleared);
    if (!intake.raised.empty() || !intake.cleared.empty() || !intake.parts.empty())
      publish(*entry, db::now_ms());
  }

  static void drop_cleared(Entry& entry, const std::vector<db::AlarmRow>& cleared) {
    std::erase_if(entry.alarms, [&](const db::AlarmRow& alarm) {
      return std::ranges::find(cleared, alarm.id, &db::AlarmRow::id) != cleared.end();
    });
  }

  /// A controller that was restarted has no alarms of before; nobody cleared them, so no event says so.
  void clear_forgotten_alarms(std::int64_t machine, std::int64_t now) {
    store.post("alarms", [this, machine, now](db::Database& db) {
      db::Transaction transaction(db);
      Intake intake;
      intake.cleared = db::clear_all_alarms(db, machine, now);
      transaction.commit();
      if (!intake.cleared.empty()) on_network([this, intake, machine] { tell(intake, machine); });
    });
  }

  asio::any_io_executor network;
  db::Store& store;
  Changes& changes;
  library::Distributor* distributor = nullptr;
  std::map<std::int64_t, Entry> entries;
  std::map<std::string, KnownProgram> programs;
  std::shared_ptr<int> life = std::make_shared<int>(0);
};

Fleet::Fleet(asio::any_io_executor network, db::Store& store, Changes& changes)
    : impl_(std::make_unique<Impl>(std::move(network), store, changes)) {
  store.now([this](db::Database& db) {
    close_after_restart(db);
    unsettle_after_restart(db);
    impl_->apply(read_picture(db));
  });
}

Fleet::~Fleet() {
  // What was posted to the store may still refer to this.
  const std::int64_t now = db::now_ms();
  for (auto& [id, entry] : impl_->entries)
    if (entry.connected) impl_->save(entry, now);
  impl_->store.now([](db::Database&) {});
  impl_->life.reset();
}

void Fleet::set_distributor(library::Distributor* distributor) {
  impl_->distributor = distributor;
}

json Fleet::live_of(std::int64_t machine) const {
  const Entry* entry = impl_->find(machine);
  return entry == nullptr ? json(nullptr) : live_json(*entry, impl_->programs, db::now_ms());
}

json Fleet::all_live() const {
  const std::int64_t now = db::now_ms();
  json all = json::array();
  for (const auto& [id, entry] : impl_->entries) all.push_back(live_json(entry, impl_->programs, now));
  return all;
}

void Fleet::tick() {
  const std::int64_t now = db::now_ms();
  for (auto& [id, entry] : impl_->entries) {
    const bool unknown = !is_current(entry, now);
    if (unknown && !entry.shown_unknown) {
      impl_->publish(entry, now);
      impl_->store.post("silence", [id = id, heard = entry.heard_ms](db::Database& db) {
        record_silence(db, id, "unknown", heard);
      });
    }
    entry.shown_unknown = unknown;
  }
}

asio::awaitable<void> Fleet::refresh() {
  const Picture picture = co_await impl_->store.run([](db::Database& db) { return read_picture(db); });
  impl_->apply(picture);
  const std::int64_t now = db::now_ms();
  for (auto& [id, entry] : impl_->entries) impl_->publish(entry, now);
}

asio::awaitable<std::int64_t> Fleet::redeem_token(std::string secret) {
  const auto in_store = [hash = db::sha256_hex(secret)](db::Database& db) {
    db::Transaction transaction(db);
    const std::int64_t machine = db::use_token(db, hash, db::now_ms());
    if (machine != 0)
      access::record(db, access::Actor{}, "machine.enrol",
                     std::string("machine:").append(std::to_string(machine)));
    transaction.commit();
    return machine;
  };
  co_return co_await impl_->store.run(in_store);
}

asio::awaitable<void> Fleet::certificate_issued(std::int64_t machine, std::string serial_hex) {
  const auto in_store = [=](db::Database& db) {
    db::Transaction transaction(db);
    db::insert_certificate(db, machine, serial_hex, db::now_ms());
    access::record(db, access::Actor{}, "machine.certificate",
                   std::string("machine:").append(std::to_string(machine)), {{"serial", serial_hex}});
    transaction.commit();
  };
  co_await impl_->store.run(in_store);
}

asio::awaitable<bool> Fleet::certificate_valid(std::int64_t machine, std::string serial_hex) {
  const auto in_store = [=](db::Database& db) { return db::certificate_valid(db, machine, serial_hex); };
  co_return co_await impl_->store.run(in_store);
}

asio::awaitable<std::string> Fleet::machine_name(std::int64_t machine) {
  const auto in_store = [machine](db::Database& db) {
    const auto row = db::machine(db, machine);
    return row ? row->name : std::string();
  };
  co_return co_await impl_->store.run(in_store);
}

void Fleet::connected(std::int64_t machine, const json& hello) {
  Entry* entry = impl_->find(machine);
  if (entry == nullptr) return;
  const std::int64_t now = db::now_ms();
  const std::string boot = text_of(hello, "boot_id");
  entry->connected = true;
  entry->heard_ms = now;
  entry->first_live = true;
  // Switched on again: if it is cut off before its first picture, nobody may read "off" from before.
  if (text_of(entry->live, "state") == "off") {
    entry->live["state"] = "unknown";
    impl_->save(*entry, now);
  }
  entry->same_boot = !boot.empty() && boot == entry->machine.boot_id;
  entry->machine.boot_id = boot;
  entry->machine.software = text_of(hello, "software");
  const std::string spool = text_of(hello, "spool_id");
  const std::int64_t acknowledged = hello.value("acknowledged", std::int64_t{0});
  impl_->store.post("connected", [=, this, same_boot = entry->same_boot](db::Database& db) {
    db::Transaction transaction(db);
    db.execute("UPDATE machines SET boot_id = ?, software = ?, last_seen_ms = ? WHERE id = ?",
               {boot, text_of(hello, "software"), now, machine});
    // What the agent was told to be committed it has thrown away: if this database is older, that is gone,
    // and is noted.
    if (!spool.empty() && acknowledged > 0) db::skip_spool_to(db, machine, spool, acknowledged, now);
    record_return(db, machine, same_boot, now);
    const bool changed = adopt_machine_file(db, machine, hello);
    transaction.commit();
    if (!changed) return;
    const auto row = db::machine(db, machine);
    impl_->on_network([this, row] {
      Entry* known = row ? impl_->find(row->id) : nullptr;
      if (known != nullptr) known->machine = *row;
    });
  });
  impl_->publish(*entry, now);
}

void Fleet::disconnected(std::int64_t machine, const std::string& reason) {
  Entry* entry = impl_->find(machine);
  if (entry == nullptr || !entry->connected) return;
  log::info("machine {} disconnected: {}", machine, reason);
  const std::int64_t now = db::now_ms();
  entry->connected = false;
  entry->shown_unknown = true;
  // An agent that said good-bye was switched off; one that was cut may well be running.
  const std::string state = reason == "shutdown" ? "off" : "unknown";
  if (state == "off" && entry->live.is_object()) entry->live["state"] = "off";
  impl_->save(*entry, now);
  impl_->store.post("disconnected", [machine, state, heard = entry->heard_ms](db::Database& db) {
    record_silence(db, machine, state, heard);
  });
  impl_->publish(*entry, now);
}

void Fleet::live(std::int64_t machine, json live) {
  Entry* entry = impl_->find(machine);
  if (entry == nullptr || !live.is_object()) return;
  const std::int64_t now = db::now_ms();
  const bool was_unknown = entry->shown_unknown;
  entry->live = std::move(live);
  entry->received_ms = now;
  entry->heard_ms = now;
  entry->connected = true;
  entry->shown_unknown = false;
  const bool no_alarms = !entry->live.contains("alarms") || entry->live["alarms"].empty();
  if (entry->first_live && !entry->same_boot && no_alarms && !entry->alarms.empty())
    impl_->clear_forgotten_alarms(machine, now);
  if (entry->first_live || was_unknown)
    // After a restart, or a silence that nobody explained, the record goes on with what the machine shows.
    impl_->store.post("state", [machine, now, state = text_of(entry->live, "state"),
                                mode = text_of(entry->live, "mode")](db::Database& db) {
      if (!state.empty()) record_state(db, machine, state, mode, now, Witness::server);
    });
  entry->first_live = false;
  if (was_unknown)
    impl_->publish(*entry, now);
  else
    impl_->publish_soon(*entry, now);
  if (now - entry->saved_ms >= kSaveEveryMs) impl_->save(*entry, now);
}

asio::awaitable<std::uint64_t> Fleet::events(std::int64_t machine, std::string spool_id, json events) {
  const std::weak_ptr<int> alive = impl_->life;
  if (Entry* entry = impl_->find(machine)) entry->heard_ms = db::now_ms();
  const auto in_store = [=](db::Database& db) {
    return take_in(db, machine, spool_id, events, db::now_ms());
  };
  const Intake intake = co_await impl_->store.run(in_store);
  if (alive.lock()) {
    impl_->tell(intake, machine);
    if (intake.offsets_changed) values_changed(machine);
  }
  co_return intake.sequence;
}

asio::awaitable<void> Fleet::census(std::int64_t machine, json programs) {
  std::vector<db::ResidentRow> rows;
  if (programs.is_array())
    for (const json& one : programs) {
      if (!one.is_object()) continue;
      db::ResidentRow row;
      row.name = text_of(one, "name");
      row.sha256 = text_of(one, "sha256");
      row.bytes = one.value("bytes", std::int64_t{0});
      if (const std::int64_t since = one.value("since_ms", std::int64_t{0}); since > 0) row.since_ms = since;
      row.selected = one.value("selected", false);
      rows.push_back(std::move(row));
    }
  const std::weak_ptr<int> alive = impl_->life;
  const auto in_store = [=](db::Database& db) { db::replace_residents(db, machine, rows, db::now_ms()); };
  co_await impl_->store.run(in_store);
  if (alive.lock())
    impl_->changes.publish(
        {"machine", machine, std::make_shared<const json>(json{{"id", machine}, {"changed", "programs"}})});
}

asio::awaitable<server::MachineAnswer> Fleet::program_requested(std::int64_t machine, std::string name) {
  if (impl_->distributor == nullptr) co_return server::MachineAnswer{false, "unsupported"};
  co_return co_await impl_->distributor->requested(machine, std::move(name));
}

asio::awaitable<void> Fleet::data_report(std::int64_t machine, std::string spool_id, const json& report) {
  const std::weak_ptr<int> alive = impl_->life;
  std::int64_t differences = 0;
  const auto in_store = [&](db::Database& db) {
    const std::int64_t now = db::now_ms();
    differences = reconcile(db, machine, spool_id, report, now);
    return settle_unknown(db, machine, now);
  };
  co_await impl_->store.run(in_store);
  if (!alive.lock()) co_return;
  if (differences > 0)
    log::warning("machine {}: {} values are not what its events told; noted as found", machine, differences);
  if (Entry* entry = impl_->find(machine))
    entry->parameter_write = report.contains("parameter_write") && report["parameter_write"] == true;
  values_changed(machine);
}

void Fleet::values_changed(std::int64_t machine) {
  impl_->changes.publish(
      {"machine", machine, std::make_shared<const json>(json{{"id", machine}, {"changed", "values"}})});
}

bool Fleet::parameter_write(std::int64_t machine) const {
  const Entry* entry = impl_->find(machine);
  return entry != nullptr && entry->connected && entry->parameter_write;
}

void Fleet::transfer_changed(const server::TransferState& state) {
  if (Entry* entry = impl_->find(state.machine); entry != nullptr && state.kind == "drip") {
    const bool over = state.state == "done" || state.state == "failed" || state.state == "cancelled";
    if (over)
      entry->drip.reset();
    else
      entry->drip = state;
  }
  if (impl_->distributor != nullptr) impl_->distributor->transfer_changed(state);
}

}  // namespace headstock::fleet
