#include "protocol/process/options.hpp"

#include <CLI/CLI.hpp>

namespace headstock::options {
namespace {

Option checked(CLI::Option& option, const CLI::Validator& validator) {
  return Option(*option.check(validator));
}

}  // namespace

Refusal::Refusal(const std::string& option, const std::string& sentence)
    : Refusal(option + ": " + sentence) {}
Refusal Refusal::missing(const std::string& option) {
  return Refusal(option + " is required");
}

Option Option::required() {
  option_->required();
  return *this;
}
Option Option::positive() {
  return checked(*option_, CLI::PositiveNumber);
}
Option Option::not_negative() {
  return checked(*option_, CLI::NonNegativeNumber);
}
Option Option::between(int least, int most) {
  return checked(*option_, CLI::Range(least, most));
}
Option Option::between(double least, double most) {
  return checked(*option_, CLI::Range(least, most));
}
Option Option::one_of(const std::vector<std::string>& words) {
  return checked(*option_, CLI::IsMember(words));
}
Option Option::existing_file() {
  return checked(*option_, CLI::ExistingFile);
}
Option Option::shows_default() {
  option_->capture_default_str();
  return *this;
}
Option Option::needs(const std::string& other) {
  option_->needs(other);
  return *this;
}
Option Option::excludes(const std::string& other) {
  option_->excludes(other);
  return *this;
}
Option Option::environment(const std::string& variable) {
  option_->envname(variable);
  return *this;
}

template <Fillable Value>
Option Command::option(const std::string& name, Value& into, const std::string& help) {
  return Option(*app_->add_option(name, into, help));
}
Option Command::flag(const std::string& name, bool& into, const std::string& help) {
  return Option(*app_->add_flag(name, into, help));
}
Command Command::add_command(const std::string& name, const std::string& help) {
  return Command(*app_->add_subcommand(name, help));
}
void Command::requires_command() {
  app_->require_subcommand(1);
}
void Command::allows_command() {
  app_->require_subcommand(0, 1);
}
void Command::callback(std::function<void()> body) {
  app_->callback(std::move(body));
}
void Command::footer(const std::string& text) {
  app_->footer(text);
}
void Command::shares_options() {
  app_->fallthrough();
}
bool Command::called() const {
  return app_->parsed();
}
bool Command::alone() const {
  return app_->get_subcommands().empty();
}

Program::Program(const std::string& about, const std::string& name)
    : Program(std::make_shared<CLI::App>(about, name)) {}
Program::Program(std::shared_ptr<CLI::App> app) : Command(*app), whole_(std::move(app)) {}

void Program::version(const std::string& line) {
  app_->set_version_flag("--version", line);
}

std::optional<int> Program::parse(int count, const char* const* arguments, int wrong) {
  try {
    app_->parse(count, arguments);
    return std::nullopt;
  } catch (const CLI::ParseError& error) {
    return app_->exit(error) == 0 ? 0 : wrong;
  } catch (const Refusal& refusal) {
    app_->exit(CLI::ValidationError(refusal.what()));
    return wrong;
  }
}

template Option Command::option(const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, std::filesystem::path&, const std::string&);
template Option Command::option(const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, std::int64_t&, const std::string&);
template Option Command::option(const std::string&, std::uint16_t&, const std::string&);
template Option Command::option(const std::string&, std::uint32_t&, const std::string&);
template Option Command::option(const std::string&, std::uint64_t&, const std::string&);
template Option Command::option(const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&);
template Option Command::option(const std::string&, std::optional<std::uint32_t>&, const std::string&);

}  // namespace headstock::options
