#include "server/fleet/orders.hpp"

#include "db/filter.hpp"
#include "db/refusal.hpp"
#include "server/access/audit.hpp"
#include "server/fleet/machines.hpp"

namespace headstock::fleet {
namespace {

using access::Action;

constexpr const char* kOrder =
    "SELECT id, name, machine_id, program, required, from_ms, by_user, closed_ms, closed_by FROM orders";

std::int64_t total_of(db::Database& db, const Order& order, const char* select, const char* time) {
  db::Where where;
  where.add(std::string(time) + " >= ?", order.from_ms);
  if (order.closed_ms) where.add(std::string(time) + " < ?", *order.closed_ms);
  if (order.machine != 0) where.add("machine_id = ?", order.machine);
  if (!order.program.empty()) where.add("program = ?", order.program);
  return db.integer(select + where.text(), where.values()).value_or(0);
}

std::vector<Order> read_orders(db::Database& db, const std::string& condition, const db::Values& values) {
  std::vector<Order> found;
  db.each(kOrder + condition, values, [&](const db::Row& row) {
    Order order;
    order.id = row.integer(0);
    order.name = row.text(1);
    order.machine = row.integer(2);
    order.program = row.text(3);
    order.required = row.integer(4);
    order.from_ms = row.integer(5);
    order.by = row.text(6);
    order.closed_ms = row.maybe_integer(7);
    order.closed_by = row.text(8);
    found.push_back(std::move(order));
  });
  for (Order& order : found) {
    order.made = total_of(db, order, "SELECT COUNT(*) FROM parts", "at_ms");
    order.rejected = total_of(db, order, "SELECT SUM(quantity) FROM rejects", "at_ms");
  }
  return found;
}

}  // namespace

std::vector<Order> orders(db::Database& db, bool open_only) {
  return read_orders(
      db, open_only ? " WHERE closed_ms IS NULL ORDER BY id DESC" : " ORDER BY id DESC LIMIT 500", {});
}

Order make_order(db::Database& db, const access::Actor& actor, Order order, std::int64_t now_ms) {
  demand(actor, Action::note_downtime);
  if (order.name.empty() || order.name.size() > 100) throw db::Refusal("bad_name", order.name.substr(0, 60));
  if (order.required < 1 || order.required > 99'999'999) throw db::Refusal("bad_value", "required");
  db::Transaction transaction(db);
  if (order.machine != 0) require_machine(db, order.machine);
  if (order.from_ms == 0) order.from_ms = now_ms;
  order.id = *db.integer(
      "INSERT INTO orders (name, machine_id, program, required, from_ms, by_user) VALUES (?, ?, ?, ?, ?, ?) "
      "RETURNING id",
      {order.name, order.machine != 0 ? db::Value(order.machine) : db::Value(), order.program.substr(0, 200),
       order.required, order.from_ms, actor.user});
  access::record(db, actor, "order.make", access::subject("order", order.id), {{"name", order.name}});
  order = read_orders(db, " WHERE id = ?", {order.id}).at(0);
  transaction.commit();
  return order;
}

Order close_order(db::Database& db, const access::Actor& actor, std::int64_t id, std::int64_t now_ms) {
  demand(actor, Action::note_downtime);
  db::Transaction transaction(db);
  const auto found = read_orders(db, " WHERE id = ?", {id});
  if (found.empty()) throw db::Refusal("not_found", access::subject("order", id));
  if (found[0].closed_ms) throw db::Refusal("already_decided", found[0].name);
  db.execute("UPDATE orders SET closed_ms = ?, closed_by = ? WHERE id = ?", {now_ms, actor.user, id});
  access::record(db, actor, "order.close", access::subject("order", id));
  const Order order = read_orders(db, " WHERE id = ?", {id}).at(0);
  transaction.commit();
  return order;
}

}  // namespace headstock::fleet
