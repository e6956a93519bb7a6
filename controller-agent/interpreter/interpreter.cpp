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
void Interpreter::data_edited() {
  executor_->update_zeros();
  executor_->take_mirror_setting();
}
void Interpreter::set_environment(macro::Environment* environment) {
  executor_->environment = environment != nullptr ? environment : &executor_->offline;
  if (executor_->macros != nullptr) executor_->macros->environment = executor_->environment;
}
bool Interpreter::interrupt(const AxisVector& machine_position, bool inside_block) {
  return executor_->interrupt(machine_position, inside_block);
}
bool Interpreter::interruption_enabled() const {
  return executor_->interruption.enabled && !executor_->interrupting();
}
Interpreter::InterruptionSignal Interpreter::interruption_signal() const {
  const auto& rules = executor_->dialect.interruption;
  const MachineData& data = executor_->data;
  const bool inside =
      rules.inside_parameter.empty() ? !data.bit(rules.between_parameter) : data.bit(rules.inside_parameter);
  return {inside, data.bit(rules.level_parameter)};
}
bool Interpreter::interruption_left_block() const {
  return executor_->interruption.left_block;
}
bool Interpreter::interruption_only_looks() const {
  return executor_->interrupting() && !executor_->interruption.acted;
}
std::uint32_t Interpreter::macro_control() const {
  return executor_->macros != nullptr ? executor_->macros->control : 0;
}
void Interpreter::start(std::unique_ptr<program::Source> main, const AxisVector& machine_position) {
  executor_->start(std::move(main), machine_position);
}
Pull Interpreter::restart(std::unique_ptr<program::Source> main, const AxisVector& machine_position,
                          const RestartPoint& point) {
  return executor_->restart(std::move(main), machine_position, point);
}
Pull Interpreter::run_through() {
  return executor_->run_through();
}
const RestartState& Interpreter::restart_state() const {
  return executor_->restart_run.state;
}
Pull Interpreter::next(Operation& out) {
  return executor_->next_on_machine(out);
}
void Interpreter::carried_out(std::uint32_t first_block_left) {
  executor_->keep_data_input(first_block_left);
}
void Interpreter::reset(const AxisVector& machine_position, std::uint32_t first_block_left) {
  executor_->reset(machine_position, first_block_left);
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
