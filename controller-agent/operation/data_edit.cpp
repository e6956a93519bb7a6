#include "operation/data_edit.hpp"

#include <cmath>

#include "dialects/data_rules.hpp"
#include "dialects/dialect.hpp"
#include "operation/controller_impl.hpp"

namespace headstock::operation {
namespace {

/// What a page shows has six digits behind the point at most: nearer than that is the same.
bool same(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return std::fabs(*a - *b) <= 5e-7;
}

}  // namespace

EditResult Controller::Impl::edit_values(const EditRequest& request) {
  const dialects::Dialect& dialect = *dialects::find(machine.profile);
  std::vector<char> names;
  for (const machine::Axis& axis : machine.axes) names.push_back(axis.name);
  const dialects::Situation situation{busy() || emergency_braking(), mode == Mode::mdi || emergency,
                                      request.parameter_write};
  interp::MachineData edited = data;
  std::vector<OffsetChanged> changes;
  for (const DataEdit& edit : request.values) {
    const interp::ValueRead now = interp::read_value(data, names, edit.what);
    if (!now.known) return {false, "bad_place", edit.what, data.version};
    if (!same(now.value, edit.before)) return {false, "changed_meanwhile", edit.what, data.version};
    // Later values of a request see the earlier ones: a group of tool life is written unit, life, tools.
    std::string why = dialects::refuse_value(dialect, edited, names, edit.what, edit.after, situation);
    if (!why.empty()) return {false, std::move(why), edit.what, data.version};
    const std::optional<double> before = interp::read_value(edited, names, edit.what).value;
    if (before.has_value() == edit.after.has_value() && (!before || *before == *edit.after)) continue;
    const std::size_t rows = edited.tools.size();
    if (!interp::write_value(edited, names, edit.what, edit.after, dialect.tools.most_offsets))
      return {false, "out_of_range", edit.what, data.version};
    // The look-ahead may hold a row of the table in its hands while a program runs.
    if (situation.running && edited.tools.size() != rows) return {false, "running", edit.what, data.version};
    changes.push_back({{edit.what, before.value_or(std::nan("")), edit.after.value_or(std::nan("")), "panel"},
                       request.origin,
                       request.by,
                       request.request});
  }
  if (changes.empty()) return {true, {}, {}, data.version};
  if (situation.running) {  // only lengths of tools: cell by cell, no row moves
    for (const OffsetChanged& change : changes)
      interp::write_value(data, names, change.change.what, change.change.after, dialect.tools.most_offsets);
  } else {
    edited.version = data.version;
    data = std::move(edited);
  }
  ++data.version;
  for (OffsetChanged& change : changes) emit(std::move(change));
  (void)mirror_place_unknown();  // it may have been switched off
  if (!situation.running) interpreter.data_edited();
  return {true, {}, {}, data.version};
}

EditResult Controller::edit_values(const EditRequest& request) {
  Access access(impl_->lock, impl_->waiting);
  return impl_->edit_values(request);
}

Taken Controller::take_events() {
  Access access(impl_->lock, impl_->waiting);
  Taken taken;
  if (impl_->run_open) impl_->mark_breakpoint();
  taken.retained = impl_->retained;
  taken.retained.run_open = impl_->run_open;
  bool about_data = false;
  for (TimedEvent& event : impl_->events) {
    about_data |= std::holds_alternative<OffsetChanged>(event.event);
    taken.events.push_back(std::move(event));
  }
  impl_->events.clear();
  if (about_data) taken.data = impl_->data;
  return taken;
}

}  // namespace headstock::operation
