#include "db/store.hpp"
#include "server/api/routes/routes.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;
using Machines = std::vector<std::int64_t>;

/// Numbers of the body; anything else is left for the handler to refuse.
Machines of_body(const Call& call) {
  Machines machines;
  if (const auto one = call.body.find("machine"); one != call.body.end() && one->is_number_integer())
    machines.push_back(one->get<std::int64_t>());
  if (const auto all = call.body.find("machines"); all != call.body.end() && all->is_array())
    for (const auto& machine : *all)
      if (machine.is_number_integer()) machines.push_back(machine.get<std::int64_t>());
  return machines;
}

awaitable<Machines> by_row(Services& s, const char* sql, std::int64_t id) {
  const auto machine = co_await s.store.run([=](db::Database& db) { return db.integer(sql, {id}); });
  Machines machines;
  if (machine) machines.push_back(*machine);
  co_return machines;
}

}  // namespace

awaitable<Machines> machines_of(Services& s, const Route& route, const Call& call) {
  const auto& pattern = route.pattern;
  if (pattern.starts_with("/machines/{id}")) co_return Machines{call.id("id")};
  if (pattern.starts_with("/ports/{id}"))
    co_return co_await by_row(s, "SELECT machine_id FROM ports WHERE id = ?", call.id("id"));
  if (pattern.starts_with("/transfers/{id}"))
    co_return co_await by_row(s, "SELECT machine_id FROM transfers WHERE id = ?", call.id("id"));
  if (pattern.starts_with("/alarm-events/{id}"))
    co_return co_await by_row(s, "SELECT machine_id FROM alarm_events WHERE id = ?", call.id("id"));
  if (pattern.starts_with("/value-requests/{id}"))
    co_return co_await by_row(s, "SELECT machine_id FROM value_requests WHERE id = ?", call.id("id"));
  if (pattern.starts_with("/counts/disagreements/{id}"))
    co_return co_await by_row(s, "SELECT machine_id FROM count_disagreements WHERE id = ?", call.id("id"));
  if (pattern.starts_with("/orders/{id}"))
    co_return co_await by_row(s, "SELECT machine_id FROM orders WHERE id = ? AND machine_id IS NOT NULL", call.id("id"));
  co_return of_body(call);
}

}  // namespace headstock::api
