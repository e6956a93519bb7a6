#include "server/fleet/punched.hpp"

#include <algorithm>

#include "interpreter/data_values.hpp"
#include "server/access/audit.hpp"
#include "server/fleet/value_requests.hpp"
#include "server/fleet/values.hpp"

namespace headstock::fleet {
namespace {

constexpr const char* kSpool = "punch";

bool has_agent(db::Database& db, std::int64_t machine) {
  return db.integer("SELECT COUNT(*) FROM certificates WHERE machine_id = ?", {machine}).value_or(0) > 0;
}

bool has_place(const MachinePages& pages, const std::string& what) {
  const interp::ValueRead read = interp::read_value(pages.data, pages.axes, what);
  return read.known && dialects::refuse_value(*pages.dialect, pages.data, pages.axes, what,
                                              read.value.value_or(0), kAnyTime) != "bad_place";
}

/// A tool life group is written by its unit, its life, its tools, then the rest of them.
int order_of(const std::string& what) {
  if (!what.starts_with("tool_life/")) return 0;
  if (what.ends_with("/unit")) return 0;
  if (what.ends_with("/life")) return 1;
  return what.find("/tool/") != what.npos ? 2 : 3;
}

class Writer {
 public:
  Writer(db::Database& db, const access::Actor& actor, const PunchedSet& set, std::int64_t now_ms)
      : db_(db), actor_(actor), set_(set), now_ms_(now_ms) {}

  /// @return false: a later punch has said something else.
  bool put(const std::string& what, std::optional<double> before, std::optional<double> after) {
    const auto later =
        db_.integer("SELECT sequence FROM machine_values WHERE machine_id = ? AND what = ? AND spool = ?",
                    {set_.machine, what, std::string(kSpool)});
    if (later && *later > set_.punch) return false;
    db::put_value(db_, set_.machine, what, after, kSpool, set_.punch, set_.at_ms);
    if (same_as_shown(before, after)) return true;
    db::ValueChangeRow change;
    change.machine = set_.machine;
    change.at_ms = set_.at_ms;
    change.received_ms = now_ms_;
    change.what = what;
    change.before = before;
    change.after = after;
    change.origin = "import";
    change.by = actor_.user;
    db::insert_value_change(db_, change);
    return true;
  }

 private:
  db::Database& db_;
  const access::Actor& actor_;
  const PunchedSet& set_;
  std::int64_t now_ms_;
};

/// "tool_life/3/": a group is punched whole.
std::string group_of(const std::string& what) {
  const auto end = what.find('/', std::string_view("tool_life/").size());
  return end == what.npos ? what : what.substr(0, end + 1);
}

void write_down(db::Database& db, const access::Actor& actor, const PunchedSet& set,
                const MachinePages& pages, std::int64_t now_ms, PunchedOutcome& outcome) {
  Writer writer(db, actor, set, now_ms);
  for (const auto& [what, value] : set.values) {
    if (!has_place(pages, what)) {
      ++outcome.without_place;
      continue;
    }
    const auto before = interp::read_value(pages.data, pages.axes, what).value;
    outcome.same += same_as_shown(before, value);
    outcome.written += writer.put(what, before, value) && !same_as_shown(before, value);
  }
  for (const auto& [what, value] : db::machine_values(db, set.machine)) {
    if (!what.starts_with("tool_life/") || set.values.contains(what)) continue;
    const auto next = set.values.lower_bound(group_of(what));
    if (next != set.values.end() && next->first.starts_with(group_of(what)))
      writer.put(what, value, std::nullopt);
  }
  rebuild_offsets(db, set.machine, now_ms);
  access::record(db, actor, "values.punched", access::subject("machine", set.machine),
                 {{"punch", std::to_string(set.punch)}, {"written", std::to_string(outcome.written)}});
}

}  // namespace

PunchedOutcome take_punched(db::Database& db, const access::Actor& actor, const PunchedSet& set,
                            std::int64_t now_ms) {
  PunchedOutcome outcome;
  if (set.machine == 0 || set.values.empty()) return outcome;
  const MachinePages pages = machine_pages(db, set.machine);
  if (!has_agent(db, set.machine)) {
    demand(actor, access::Action::edit_offsets);
    write_down(db, actor, set, pages, now_ms, outcome);
    return outcome;
  }
  NewValueRequest request;
  for (const auto& [what, value] : set.values) {
    const auto now = interp::read_value(pages.data, pages.axes, what).value;
    if (!has_place(pages, what))
      ++outcome.without_place;
    else if (same_as_shown(now, value))
      ++outcome.same;
    else
      request.items.push_back({what, now, value, std::nullopt, false});
  }
  outcome.differ = static_cast<std::int64_t>(request.items.size());
  if (!set.write || request.items.empty()) return outcome;
  std::ranges::stable_sort(request.items, {}, [](const db::ValueItem& item) { return order_of(item.what); });
  request.machine = set.machine;
  request.origin = "import";
  request.why = set.why;
  outcome.request = ask_values(db, actor, request, now_ms);
  return outcome;
}

}  // namespace headstock::fleet
