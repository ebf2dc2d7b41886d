#include "tools/truepose/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <concepts>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <map>
#include <optional>
#include <set>

#include "config/number_text.hpp"
#include "config/text_file.hpp"
#include "daemon/control/version_text.hpp"
#include "proto/text/renamed.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

int complain(std::string message, int exit_code) {
  std::ranges::replace(message, '\n', ' ');
  print_to_stderr("truepose: " + message);
  return exit_code;
}

Check check_of(const CLI::Validator& validator) {
  return {validator.get_description(), [validator](const std::string& value) { return validator(value); }};
}

CLI::Option* add_target(CLI::App& to, const Option& option, bool* value) {
  return to.add_flag(option.name, *value, option.help);
}

CLI::Option* add_target(CLI::App& to, const Option& option, std::optional<bool>* value) {
  CLI::Option* yes = to.add_flag_callback(
      option.name, [value] { *value = true; }, option.help);
  to.add_flag_callback(
        "--no-" + option.name.substr(2), [value] { *value = false; }, "do not")
      ->excludes(yes);
  return yes;
}

template <typename T>
CLI::Option* add_target(CLI::App& to, const Option& option, T* value) {
  return to.add_option(option.name, *value, option.help);
}

template <typename T>
CLI::Option* add_target(CLI::App& to, const Option& option, std::vector<T>* value) {
  return to.add_option(option.name, *value, option.help)->delimiter(',');
}

std::string not_empty(const std::string& file) { return file.empty() ? "expected a file's name" : ""; }

std::string why_no_number(const std::string& text) {
  const auto number = config::parse_number(text);
  return number ? "" : number.error();
}

template <typename T>
constexpr bool kHoldsNumbers =
    std::same_as<T, double> || std::same_as<T, std::optional<double>> || std::same_as<T, std::vector<double>>;

/// What the environment says in place of an option; null: nothing.
const char* from_environment(const OptionRules& rules) {
  const char* const given = rules.environment.empty() ? nullptr : std::getenv(rules.environment.c_str());
  return given != nullptr && *given != '\0' ? given : nullptr;
}

/// Before words are read, so that these win. The library asks the environment once for each command that has
/// the option, after the words of the one that is called, and all of them may have one target.
void take_from_environment(const Option& option) {
  const auto take = [given = from_environment(option.rules)]<class T>(T* value) {
    if constexpr (std::same_as<T, std::string> || std::same_as<T, std::filesystem::path>) {
      if (given != nullptr) *value = given;
    }
  };
  std::visit(take, option.target);
}

CLI::Option* add_option(CLI::App& to, const Option& option) {
  const OptionRules& rules = option.rules;
  CLI::Option* const added =
      std::visit([&](auto* value) { return add_target(to, option, value); }, option.target);
  if (rules.required) added->required();
  if (rules.file != FileUse::None) added->check(CLI::Validator{not_empty, ""});
  if (std::visit([]<class T>(T*) { return kHoldsNumbers<T>; }, option.target))
    added->check(CLI::Validator{why_no_number, ""});
  if (rules.check) added->check(CLI::Validator{rules.check->why_not, rules.check->shown});
  if (!rules.type.empty()) added->type_name(rules.type);
  if (rules.count > 0) added->expected(rules.count);
  if (rules.repeats) added->allow_extra_args(false)->delimiter('\0');  // a file's name may hold a comma
  take_from_environment(option);
  if (!rules.environment.empty())
    added->description(option.help + " (without it: what " + rules.environment + " says)");
  if (rules.shows_default) added->capture_default_str();
  return added;
}

void add_options(CLI::App& to, const std::vector<Option>& options, CLI::App* subjects = nullptr) {
  std::map<std::string, CLI::Option*> added;
  for (const Option& option : options)
    added[option.name] = add_option(option.rules.is_subject ? *subjects : to, option);
  std::set<std::string> given;  // by the environment
  for (const Option& option : options)
    if (from_environment(option.rules) != nullptr) given.insert(option.name);
  for (const Option& option : options) {
    for (const std::string& other : option.rules.needs)
      if (!given.contains(other)) added[option.name]->needs(added.at(other));
    for (const std::string& other : option.rules.excludes) added[option.name]->excludes(added.at(other));
  }
}

/// @param app     a command "campaign start" is added to the group before it
/// @param before  options before the command
void add_command(CLI::App& app, const Command& command, const std::vector<Option>& before, int& exit_code) {
  const std::size_t space = command.name.find(' ');
  CLI::App& parent = space == std::string::npos ? app : *app.get_subcommand(command.name.substr(0, space));
  CLI::App* const sub = parent.add_subcommand(command.name.substr(space + 1), command.help);
  if (!command.run) {
    sub->require_subcommand(1);
    return;
  }
  CLI::App* const subjects = command.subjects.empty()
                                 ? nullptr
                                 : sub->add_option_group("targets", command.subjects)->require_option(1);
  add_options(*sub, command.options, subjects);
  sub->callback([&] {
    refuse_overwriting({before, command.options});
    exit_code = command.run();
  });
}

/// What is wrong with an option that was renamed; nothing where none was.
std::optional<std::string> renamed_option(const CLI::App& app) {
  if (const auto given = app.get_subcommands(); !given.empty()) return renamed_option(*given.front());
  std::vector<std::string> known;
  const auto add = [&](const CLI::App& part) {
    for (const CLI::Option* option : part.get_options()) known.push_back(option->get_name());
  };
  add(app);
  for (const CLI::App* group : app.get_subcommands([](const CLI::App*) { return true; }))
    if (group->get_name().empty()) add(*group);
  for (const std::string& word : app.remaining()) {
    const std::string option = word.substr(0, word.find('='));
    if (const std::string renaming = renamed(option, known); !renaming.empty())
      return option + ": unknown option" + renaming;
  }
  return std::nullopt;
}

/// What is wrong with words that name no command where one is expected; nothing where it is something else.
std::optional<std::string> unknown_command(const CLI::App& app) {
  if (const auto given = app.get_subcommands(); !given.empty()) return unknown_command(*given.front());
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    if (!command->get_name().empty()) known.push_back(command->get_name());
  const std::vector<std::string> words = app.remaining();
  if (known.empty() || words.empty() || words.front().starts_with('-')) return std::nullopt;
  const std::string group = app.get_parent() ? " of " + app.get_name() : "";
  return config::in_quotes(words.front()) + " is no command" + group +
         config::suggestion(words.front(), known);
}

}  // namespace

CommandError bad_usage(const std::string& message) { return {kBadInput, message + " (see truepose --help)"}; }

Check in_range(int least, int most) { return check_of(CLI::Range{least, most}); }
Check in_range(double least, double most) { return check_of(CLI::Range{least, most}); }
Check member_of(std::vector<std::string> values) { return check_of(CLI::IsMember{std::move(values)}); }

Check available(std::vector<std::string_view> values) {
  const std::string all = CLI::detail::join(values, ", ");
  return {"{" + all + "}", [values = std::move(values), all](const std::string& value) -> std::string {
            if (std::ranges::find(values, value) != values.end()) return {};
            return "'" + value + "' is not available in this version (available: " + all + ")" +
                   renamed(value, values);
          }};
}

void flush_standard_output() {
  errno = 0;
  std::cout.flush();
  std::fflush(stdout);
  const std::string why = errno == 0 ? "" : std::string{": "} + std::strerror(errno);
  if (!std::cout || std::ferror(stdout) != 0)
    throw CommandError{kBadInput, "standard output cannot be written" + why};
}

void print_to_stderr(const std::string& sentence) {
  std::cout.flush();
  std::fflush(stdout);
  std::fprintf(stderr, "%s\n", sentence.c_str());
}

int run_command_line(const CommandLine& line, std::vector<std::string> words) {
  const int ended = exit_code_of([&] {
    int exit_code = kDone;
    CLI::App app{"Calibrates industrial robots with a laser tracker, and corrects them while they work.",
                 "truepose"};
    app.set_version_flag("--version", daemon::version_text("truepose"));
    app.require_subcommand(1);
    add_options(app, line.options);
    for (const Command& command : line.commands) add_command(app, command, line.options, exit_code);
    try {
      std::ranges::reverse(words);  // as CLI11 takes them
      app.parse(std::move(words));
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
      const auto renaming = renamed_option(app);
      throw bad_usage(renaming ? *renaming : unknown_command(app).value_or(error.what()));
    }
    return exit_code;
  });
  if (ended > kFailed) return ended;  // says already why nothing can be relied on
  return exit_code_of([ended] {
    flush_standard_output();
    return ended;
  });
}

int exit_code_of(const std::function<int()>& work) try { return work(); } catch (const CommandError& error) {
  return complain(error.message, error.exit_code);
} catch (const config::ConfigError& error) {
  return complain(error.what(), kBadInput);
} catch (const std::exception& error) {
  return complain(error.what(), kFailed);
}

}  // namespace truepose::tools
