// The command line of a program: its options, its sub-commands, what they demand, and how they explain
// themselves. Everything here is for the main thread before others run, except what a callback does itself.
//
// A variable that an option fills must live until the command line has been read (callbacks included). It
// keeps the value it has where the option is not given. Mistakes in the description itself (a name twice, an
// option that `needs` names but nobody added) throw std::exception where they are made: they are defects of
// the program, not of who calls it.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace headstock::options {

/// What an option can fill. Whole numbers are refused outside the range of their type; a vector takes every
/// value that is given, an optional stays empty when none is. (Another type: add it here and to the list at
/// the end of the source.)
template <class Value, class... Types>
concept OneOf = (std::same_as<Value, Types> || ...);
template <class Value>
concept Fillable =
    OneOf<Value, std::string, std::filesystem::path, int, std::int64_t, std::uint16_t, std::uint32_t,
          std::uint64_t, double, std::vector<std::string>, std::optional<std::uint32_t>>;

/// Thrown by a callback: a value that only the program can judge is wrong. Told like every other wrong
/// option.
class Refusal : public std::runtime_error {
 public:
  /// @param option with its dashes. @param sentence what the option takes, and what it was given.
  Refusal(const std::string& option, const std::string& sentence);
  /// A required option that was not given.
  static Refusal missing(const std::string& option);

 private:
  explicit Refusal(const std::string& line) : std::runtime_error(line) {}
};

/// One option, as a handle: it may be copied, and dropped when nothing more is to be said about it.
class Option {
 public:
  explicit Option(CLI::Option& option) : option_(&option) {}

  Option required();
  Option positive();                          ///< a number above 0
  Option not_negative();                      ///< a number, 0 or more
  Option between(int least, int most);        ///< both included
  Option between(double least, double most);  ///< both included
  Option one_of(const std::vector<std::string>& words);
  Option existing_file();
  Option shows_default();                     ///< the help shows the value that the variable has now
  Option needs(const std::string& other);     ///< an option of the same command, added before
  Option excludes(const std::string& other);  ///< an option of the same command, added before
  Option environment(
      const std::string& variable);  ///< where the value comes from when the option is not given

 private:
  CLI::Option* option_;
};

/// The program or one of its sub-commands, as a handle: it may be copied; the Program owns what it stands
/// for.
class Command {
 public:
  explicit Command(CLI::App& app) : app_(&app) {}

  /// @param name "--folder", "-o,--output", or without dashes a value told by its place, as "FILE".
  template <Fillable Value>
  Option option(const std::string& name, Value& into, const std::string& help = {});
  /// True when given; --name=false takes it back.
  Option flag(const std::string& name, bool& into, const std::string& help = {});

  Command add_command(const std::string& name, const std::string& help);
  void requires_command();  ///< exactly one of its sub-commands
  void allows_command();    ///< one of them or none
  /// What it does. Runs when the whole command line was found right, those of its sub-commands first.
  void callback(std::function<void()> body);
  /// The line or lines below its help.
  void footer(const std::string& text);
  /// Its options are also taken behind the names of sub-commands added from now on.
  void shares_options();

  bool called() const;  ///< it stood in the command line
  bool alone() const;   ///< none of its sub-commands did

 private:
  friend class Program;
  CLI::App* app_;
};

class Program : public Command {
 public:
  /// @param name as the help shows it; empty: as the program was called.
  explicit Program(const std::string& about, const std::string& name = {});

  /// The answer to --version.
  void version(const std::string& line);

  /// Reads the command line and runs the callbacks; tells on stderr what is wrong, or help and version on
  /// stdout.
  /// @param wrong exit status of a wrong command line.
  /// @return the exit status when the program has nothing left to do: 0 after help or version, otherwise
  /// WRONG.
  [[nodiscard]] std::optional<int> parse(int count, const char* const* arguments, int wrong);

 private:
  explicit Program(std::shared_ptr<CLI::App> app);
  std::shared_ptr<CLI::App> whole_;
};

}  // namespace headstock::options
