// What comes in: a punch becomes records that wait for a person, a request is answered.

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/blobs.hpp"
#include "db/program_store.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "protocol/process/log.hpp"
#include "server/dnc/received.hpp"
#include "server/dnc/service.hpp"

namespace headstock::dnc {

namespace asio = boost::asio;
using asio::awaitable;

void Dnc::Impl::on_receiving(std::int64_t port, const serial::ReceiveReport& report,
                             const std::shared_ptr<std::string>& text) {
  Unit& at = unit(port);
  const bool empty = report.bytes == 0;
  // A punch that came while a request was being looked through is kept as well.
  if (!at.job && !empty && (!at.starting || report.over())) begin_receiving(at, "control");
  if (!at.job) return;
  auto& row = at.job->row;
  if (row.id != 0 && row.kind != "receive") return;
  row.state = serial::name_of(report.state);
  row.bytes = static_cast<std::int64_t>(report.bytes);
  if (!row.started_ms && !empty) row.started_ms = db::now_ms();
  if (!report.over()) return changed(port);
  row.reason = report.reason;
  row.detail = report.text;
  const auto finished = std::exchange(at.job, std::nullopt)->row;
  at.starting = true;  // nothing else begins before this punch is put away
  asio::co_spawn(
      io,
      [self = shared_from_this(), port, finished, text, closed = report.closed]() -> awaitable<void> {
        co_await self->put_away(port, finished, text, closed);
      },
      [self = shared_from_this(), port](std::exception_ptr error) {
        const auto found = self->units.find(port);
        if (found != self->units.end()) {
          found->second->starting = false;
          self->next_in_queue(*found->second);
        }
        if (error) log::error("a punch could not be put away");
        self->changed(port);
      });
}

void Dnc::Impl::begin_receiving(Unit& at, const std::string& by) {
  Job job;
  job.row.port = at.row.id;
  job.row.kind = "receive";
  job.row.state = "waiting";
  job.row.by = by;
  job.row.created_ms = db::now_ms();
  job.row.settings_json = to_json(at.settings).dump();
  at.job = std::move(job);  // its record is written with its end: noise leaves none
}

awaitable<void> Dnc::Impl::put_away(std::int64_t port, db::PortTransferRow row,
                                    std::shared_ptr<std::string> text, bool closed) {
  const db::PortRow port_row = unit(port).row;
  const PortSettings settings = unit(port).settings;
  Punch punch;
  if (row.state == "done") {
    const auto apart = [this, &text, closed, &settings, &port_row] {
      return take_apart(*text, closed, settings, port_row, blobs);
    };
    try {
      punch = co_await workers.run(apart);
    } catch (const std::exception& error) {
      punch.reason = "not_kept";
      punch.where = error.what();
    }
    if (!punch.reason.empty()) {
      row.state = "failed";
      row.reason = punch.reason;
      row.detail = punch.where;
    }
  }
  const auto asked = row.state == "done" ? wanted(punch.text, unit(port).rules) : Wanted{};
  row.ended_ms = db::now_ms();
  row.name = asked.rule != nullptr ? asked.name : punch.pieces.empty() ? "" : punch.pieces.front().row.name;
  row.total = row.bytes;
  const auto put = [this, &row, &punch, &port_row, asked](db::Database& db) {
    db::Transaction transaction(db);
    row.id = db::insert_port_transfer(db, row);
    db::update_port_transfer(db, row);
    if (row.state == "done" && asked.rule == nullptr)
      keep(db, blobs, std::move(punch), port_row, row.id, db::now_ms());
    transaction.commit();
  };
  co_await store.run(put);
  log::info("port {}: received {} characters, {}{}{}", port_row.name, row.bytes, row.state,
               row.reason.empty() ? "" : ", ", row.reason);
  if (asked.rule == nullptr) co_return;
  const RequestRule rule = *asked.rule;
  const std::string name = asked.name;
  co_await answer(port, rule, name);
}

/// The control has asked for a program, or for the list.
awaitable<void> Dnc::Impl::answer(std::int64_t port, RequestRule rule, std::string name) {
  Unit& at = unit(port);
  Job job;
  job.row.port = port;
  job.row.kind = "answer";
  job.row.state = "waiting";
  job.row.name = name;
  job.row.by = "control";
  job.row.created_ms = db::now_ms();
  job.row.settings_json = to_json(at.settings).dump();
  std::string reason;
  const std::string folder = at.row.folder;
  if (rule.action == RequestRule::list) {
    const auto list = [folder](db::Database& db) {
      db::ProgramFilter filter;
      filter.folder = folder;
      return db::programs(db, filter, {0, 1000}).items;
    };
    const auto programs = co_await store.run(list);
    job.text.header =
        std::string("%\n").append(rule.name.empty() ? "O9999" : rule.name).append("(PROGRAMS)\n");
    for (const auto& program : programs)
      if (program.released) job.text.header.append("(").append(program.name).append(")\n");
    job.text.header.append("M30\n%\n");
  } else {
    const auto look = [folder, name](db::Database& db) { return db::program_named(db, folder, name); };
    const auto program = co_await store.run(look);
    if (!program)
      reason = "not_found";
    else if (!program->released)
      reason = "not_released";
    if (reason.empty()) {
      job.row.program = program->id;
      job.row.revision = program->released->number;
      job.row.sha256 = program->released->blob.sha256;
      job.text.file = blobs.path(job.row.sha256).string();
    }
  }
  if (reason.empty()) {
    const OutgoingFacts facts = co_await looked_through(job.text, unit(port).settings);
    reason = facts.reason;
    job.row.detail = facts.where;
    job.row.total = static_cast<std::int64_t>(facts.bytes);
    job.row.wire_sha256 = facts.sha256;
  }
  if (!reason.empty()) {
    job.row.state = "failed";
    job.row.reason = reason;
    job.row.ended_ms = db::now_ms();
  }
  const auto put = [&job](db::Database& db) {
    job.row.id = db::insert_port_transfer(db, job.row);
    if (job.row.ended_ms) db::update_port_transfer(db, job.row);
  };
  co_await store.run(put);
  Unit& now = unit(port);
  if (reason.empty()) start_job(now, std::move(job));
  changed(port);
}

}  // namespace headstock::dnc
