#include "interpreter/interpreter.hpp"

#include <utility>

#include "interpreter/executor.hpp"

namespace headstock::interp {

Interpreter::Interpreter(const dialects::Dialect& dialect, const machine::Machine& machine, MachineData& data,
                         program::Programs* programs)
    : executor_(std::make_unique<Executor>(dialect, machine, data, programs)) {}

Interpreter::~Interpreter() = default;

void Interpreter::set_switches(const Switches& switches) {
  executor_->set_switches(switches);
}
void Interpreter::on_data_change(DataChanged callback) {
  executor_->changed = std::move(callback);
}
void Interpreter::start(std::unique_ptr<program::Source> main, const AxisVector& machine_position) {
  executor_->start(std::move(main), machine_position);
}
Pull Interpreter::next(Operation& out) {
  return executor_->next_on_machine(out);
}
void Interpreter::reset(const AxisVector& machine_position) {
  executor_->reset(machine_position);
}
void Interpreter::set_position(const AxisVector& machine_position) {
  executor_->set_position(machine_position);
}
void Interpreter::skip_ended(const AxisVector& machine_position, bool triggered) {
  executor_->skip_ended(machine_position, triggered);
}
void Interpreter::tool_cut_for(double seconds) {
  tool_life::cut_for(*executor_, seconds);
}
const ModalSnapshot& Interpreter::modal() const {
  return executor_->modal_on_machine();
}
AxisVector Interpreter::to_work(const AxisVector& machine_position, const ModalSnapshot& modal) const {
  return executor_->to_work(machine_position, modal);
}

}  // namespace headstock::interp
