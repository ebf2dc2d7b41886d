#pragma once

#include <cstdint>
#include <expected>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "tools/steering/exit_code.hpp"

namespace truepose::tools {

using enum steering::ExitCode;

/// Why a command ends without its result, or though it printed it. Thrown, it becomes a line on standard
/// error and the exit code.
struct CommandError {
  int exit_code = kFailed;
  std::string message;        ///< one sentence
  std::string see{};          ///< where the right usage is shown: "truepose calibrate --help"
  std::optional<int> code{};  ///< of the control protocol, where the daemon refused it
};

/// Options that do not go together, or one that is missing. The command's own help is named with it.
CommandError bad_usage(const std::string& message);

/// Throws CommandError.
template <typename T>
T value_or_throw(std::expected<T, CommandError> result) {
  if (!result) throw std::move(result.error());
  return *std::move(result);
}

/// What an option's value may be.
struct Check {
  std::string shown;                                             ///< in --help: "0.01 to 0.99"
  std::function<std::string(const std::string& value)> why_not;  ///< empty for a value that may be
  std::vector<std::string> values{};                             ///< all that may be, where these are few
};
Check in_range(int least, int most);
Check in_range(double least, double most);
/// Refuses a value that this version does not offer, and names those that it does.
Check available(const std::vector<std::string_view>& values);

/// Where the value of an option goes, which says its type. An optional stays empty where the option is not
/// given; the parts of a list stand between commas; a bool is a flag, and an optional one has a --no-... too.
using OptionTarget =
    std::variant<bool*, std::optional<bool>*, int*, std::optional<int>*, std::optional<std::int64_t>*,
                 std::uint64_t*, std::optional<std::uint64_t>*, double*, std::optional<double>*, std::string*,
                 std::filesystem::path*, std::vector<int>*, std::vector<double>*, std::vector<std::string>*>;

/// What a command does with the files that an option names.
enum class FileUse { None, Read, Written };

struct OptionRules {
  bool required = false;
  bool shows_default = false;
  std::optional<Check> check{};
  std::string type{};    ///< kind of its value in --help: "MM", "DEG", "DIR"; a file is a FILE without it
  std::string place{};   ///< "ROBOT": it may be given without its name too, in the order of the options
  int count = 0;         ///< of the parts of a list; 0: any
  bool repeats = false;  ///< a list whose parts are given one by one, each with the option's name
  std::vector<std::string> needs{}, excludes{};  ///< other options of the command
  std::string environment{};  ///< variable that says the value, a text or a path, where no word does
  bool is_subject = false;    ///< of several, exactly one is given: what the command is about
  std::string key{};          ///< parameter of the command's method that it becomes
  std::string id_of{};        ///< "campaign": it takes an id of the daemon's, its start, or "latest"
  FileUse file = FileUse::None;
  std::function<std::vector<std::string>()> candidates{};  ///< values that a shell offers
};

/// An option of a command. "--out" is "-o" too, and so are the others of kShortNames (option_names.hpp).
struct Option {
  std::string name;  ///< "--robot"; without dashes it goes by its place alone
  OptionTarget target;
  std::string help;
  OptionRules rules{};
};

/// What a command is for, which is the group that `truepose --help` shows it in.
enum class Task { Files, Daemon, Cell, Diagnosis };

/// A command line that does something useful, without the program's name.
struct Example {
  std::string line;  ///< "drift arm.yaml model.yaml five.csv"
  std::string what{};
};

struct Command {
  std::string name;  ///< "status", "campaign start"
  std::string help;
  std::vector<Option> options{};
  std::function<int()> run{};  ///< @return the exit code. May throw. None: a group, as "campaign"
  std::string method{};        ///< of the daemon that it calls
  std::string subjects{};      ///< what those of its options are that are subjects
  Task task = Task::Files;     ///< of a command that stands in no group
  std::vector<Example> examples{};
};

struct CommandLine {
  std::vector<Option> options;  ///< before the command
  std::vector<Command> commands;
};

/// Throws CommandError where not all that was printed arrived, as on a full disk.
void flush_standard_output();

/// Says on standard error what is no part of the answer, behind all that was printed before: where both go to
/// one file it would stand in the midst of it. Nothing with --quiet.
void print_to_stderr(const std::string& sentence);

/// Runs the command that the words ask for. Without any, or with a group alone, prints the help. With --json
/// an error is one line of JSON on standard error. @return the exit code: kBadInput too where what it printed
/// did not arrive
int run_command_line(const CommandLine& line, std::vector<std::string> words);

/// Does the work; what it throws becomes a line on standard error. @return the exit code
int exit_code_of(const std::function<int()>& work);

}  // namespace truepose::tools
