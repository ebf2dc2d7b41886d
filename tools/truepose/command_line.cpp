#include "tools/truepose/command_line.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <concepts>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "config/number_text.hpp"
#include "config/text_file.hpp"
#include "daemon/control/version_text.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "tools/truepose/completion/completions.hpp"
#include "tools/truepose/help_text.hpp"
#include "tools/truepose/option_names.hpp"
#include "tools/truepose/terminal.hpp"
#include "tools/truepose/written_files.hpp"

namespace truepose::tools {
namespace {

/// Why a command ended, as --json has it.
struct PrintedError {
  int exit_code = kFailed;
  std::optional<int> code;
  std::string message;
  std::optional<std::string> see;
};
void layout(record::Io& io, PrintedError& x) {
  io("exit_code", x.exit_code);
  io.defaulted("code", x.code);
  io("message", x.message);
  io.defaulted("see", x.see);
}

struct ErrorDocument {
  PrintedError error;
};
void layout(record::Io& io, ErrorDocument& x) { io("error", x.error); }

/// On standard error, behind all that was printed before.
void print_line(const std::string& text) {
  std::cout.flush();
  std::fflush(stdout);
  const char* const over_progress = is_terminal(STDERR_FILENO) ? "\x1b[K" : "";
  std::fprintf(stderr, "%s%s\n", over_progress, text.c_str());
}

int complain(CommandError error, bool as_json) {
  std::ranges::replace(error.message, '\n', ' ');
  const std::string& see = error.see;
  if (as_json) {
    const ErrorDocument document{
        {error.exit_code, error.code, error.message, see.empty() ? std::nullopt : std::optional{see}}};
    print_line(control::json_text(record::to_json(document)));
  } else {
    print_line("truepose: " + error.message + (see.empty() ? "" : " (see " + see + ")"));
  }
  return error.exit_code;
}

int exit_code_as(bool as_json, const std::function<int()>& work) try {
  return work();
} catch (const CommandError& error) {
  return complain(error, as_json);
} catch (const config::ConfigError& error) {
  return complain({kBadInput, error.what()}, as_json);
} catch (const std::exception& error) {
  return complain({kFailed, error.what()}, as_json);
}

// ---- From options to CLI11 ----

/// "--out,-o", "ROBOT,--robot"
std::string names_for_parser(const Option& option) {
  std::string names = option.rules.place.empty() ? option.name : option.rules.place + "," + option.name;
  if (const std::string_view letter = short_name(option.name); !letter.empty()) (names += ",") += letter;
  return names;
}

CLI::Option* add_target(CLI::App& to, const Option& option, bool* value) {
  return to.add_flag(names_for_parser(option), *value);
}

CLI::Option* add_target(CLI::App& to, const Option& option, std::optional<bool>* value) {
  CLI::Option* yes = to.add_flag_callback(option.name, [value] { *value = true; });
  to.add_flag_callback(negated_name(option), [value] { *value = false; })->excludes(yes);
  return yes;
}

template <typename T>
CLI::Option* add_target(CLI::App& to, const Option& option, T* value) {
  return to.add_option(names_for_parser(option), *value);
}

template <typename T>
CLI::Option* add_target(CLI::App& to, const Option& option, std::vector<T>* value) {
  return to.add_option(names_for_parser(option), *value)->delimiter(',');
}

std::string not_empty(const std::string& file) { return file.empty() ? "expected a file's name" : ""; }

std::string why_no_number(const std::string& text) {
  const auto number = config::parse_number(text);
  if (number) return {};
  std::string with_point = text;
  std::ranges::replace(with_point, ',', '.');
  const bool is_decimal_comma = config::parse_number(with_point).has_value();
  return number.error() + (is_decimal_comma ? ". Write " + with_point : "");
}

/// As parse_number() reads numbers: CLI11 would take 010 as octal.
template <typename T>
std::string why_not_whole(const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool leads_with_zero = text.size() > 1 && text.find_first_not_of('-') == text.find('0');
  if (error == std::errc::result_out_of_range && end == text.data() + text.size())
    return "expected a whole number of at most " + std::to_string(std::numeric_limits<T>::max()) +
           ", found " + config::in_quotes(text);
  if (error == std::errc{} && end == text.data() + text.size() && !leads_with_zero) return {};
  return std::string{"expected a whole number"} + (std::unsigned_integral<T> ? " of 0 or more" : "") +
         ", found " + config::in_quotes(text);
}

template <typename T>
struct NumberOf {
  using Type = T;
};
template <typename T>
struct NumberOf<std::optional<T>> : NumberOf<T> {};
template <typename T>
struct NumberOf<std::vector<T>> : NumberOf<T> {};

void check_numbers(CLI::Option& added, const Option& option) {
  const auto check = [&]<class Target>(Target*) {
    using T = typename NumberOf<Target>::Type;
    if constexpr (std::same_as<T, double>)
      added.check(CLI::Validator{why_no_number, ""});
    else if constexpr (std::integral<T> && !std::same_as<T, bool>)
      added.check(CLI::Validator{why_not_whole<T>, ""});
  };
  std::visit(check, option.target);
}

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
  check_numbers(*added, option);
  if (rules.check) added->check(CLI::Validator{rules.check->why_not, ""});
  added->type_name(kind_of(option));
  if (rules.count > 0) added->expected(rules.count);
  if (rules.repeats) added->allow_extra_args(false)->delimiter('\0');  // a file's name may hold a comma
  take_from_environment(option);
  return added;
}

/// Of the options that say what the command is about, exactly one is given. Throws CommandError.
void expect_one_subject(const std::vector<Option>& options, const CLI::App& app) {
  std::string names;
  std::vector<std::string> given;
  for (const Option& option : options) {
    if (!option.rules.is_subject) continue;
    names += (names.empty() ? "" : ", ") + option.name;
    if (app.count(option.name) > 0) given.push_back(option.name);
  }
  if (names.empty() || given.size() == 1) return;
  if (given.empty()) throw bad_usage(names + ": missing. Give one of them");
  throw bad_usage(given[0] + ": excludes " + given[1] + ". Give one of them");
}

void add_options(CLI::App& to, const std::vector<Option>& options) {
  std::map<std::string, CLI::Option*> added;
  for (const Option& option : options) added[option.name] = add_option(to, option);
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
  CLI::App* const sub = parent.add_subcommand(command.name.substr(space + 1));
  if (!command.run) {
    sub->require_subcommand(1);
    return;
  }
  add_options(*sub, command.options);
  sub->callback([&, sub] {
    expect_one_subject(command.options, *sub);
    refuse_overwriting({before, command.options});
    exit_code = command.run();
  });
}

// ---- Words that are wrong ----

const CLI::App& innermost(const CLI::App& app) {
  const auto given = app.get_subcommands();
  return given.empty() ? app : innermost(*given.front());
}

/// "campaign start"; empty: no command was given.
std::string command_name(const CLI::App& app) {
  if (app.get_parent() == nullptr) return {};
  const std::string above = command_name(*app.get_parent());
  return above.empty() ? app.get_name() : above + " " + app.get_name();
}

std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string unknown_option(const CLI::App& app, const std::string& word) {
  const std::string option = word.substr(0, word.find('='));
  return option + ": unknown option" + config::suggestion(option, option_names(app));
}

std::string unknown_command(const CLI::App& app, const std::string& word) {
  std::vector<std::string> known;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    known.push_back(command->get_name());
  if (known.empty()) return config::in_quotes(word) + " is one argument too many. Name the option it is for";
  const std::string group = app.get_parent() ? " of " + app.get_name() : "";
  return config::in_quotes(word) + " is no command" + group + config::suggestion(word, known);
}

/// Of an option with too few or too many values.
std::string wrong_count(const CLI::App& app, const std::string& message) {
  const std::string name = message.substr(0, message.find(": "));
  const CLI::Option* const option = app.get_option_no_throw(name);
  if (option == nullptr) return message;
  const auto found = option->results();
  if (found.empty()) return name + ": expected " + option->get_type_name() + " behind it, found nothing";
  if (option->get_expected_max() > 1)
    return name + ": expected " + std::to_string(option->get_expected_max()) + " values, found " +
           std::to_string(found.size());
  std::string all;
  for (const std::string& value : found) all += (all.empty() ? "" : ", ") + value;
  return name + ": given " + std::to_string(found.size()) + " times (" + all + "). Give it once";
}

/// As the help shows the name of what goes by its place.
std::string in_capitals(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::toupper(c); });
  return name;
}

/// Of "--robot is required" and how it is given.
std::string missing_option(const CLI::App& app, const std::string& message) {
  const std::string name = message.substr(0, message.find(' '));
  const CLI::Option* const option = app.get_option_no_throw(name);
  if (option == nullptr) return message;
  if (!name.starts_with('-')) return in_capitals(name) + ": missing. Give it behind the command";
  const std::string place = option->get_positional() ? option->get_name(true) + " or " : "";
  return name + ": missing. Give " + place + name + " " + option->get_type_name();
}

/// Of "--data requires --robot": all that it requires and that are not given, since the parser names any of
/// them.
std::string missing_partners(const CLI::App& app, const std::string& message) {
  const std::string name = message.substr(0, message.find(' '));
  const CLI::Option* const option = app.get_option_no_throw(name);
  if (option == nullptr) return message;
  std::set<std::string> missing;
  for (const CLI::Option* each : option->get_needs())
    if (each->count() == 0) missing.insert(each->get_name());
  std::string all;
  for (const std::string& each : missing) all += (all.empty() ? "" : " and ") + each;
  return name + ": requires " + all + ". Give " + (missing.size() > 1 ? "all" : "both");
}

/// What is wrong with the words, in the words of who wrote them.
std::string usage_fault(const CLI::App& app, const CLI::ParseError& error) {
  for (const CLI::App* each = &app; each != nullptr; each = each->get_parent())
    for (const std::string& word : each->remaining())
      return word.starts_with('-') && word.size() > 1 ? unknown_option(*each, word)
                                                      : unknown_command(*each, word);
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) return wrong_count(app, error.what());
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) return missing_option(app, error.what());
  if (dynamic_cast<const CLI::RequiresError*>(&error) != nullptr) return missing_partners(app, error.what());
  if (dynamic_cast<const CLI::ExcludesError*>(&error) != nullptr) {
    std::string message = error.what();
    message.insert(std::min(message.find(' '), message.size()), ":");
    return message + ". Give one of them";
  }
  return error.what();
}

/// The options that all commands have.
void add_manner(Command& command) {
  if (!command.run) return;
  command.options.push_back({"--quiet", &manner().quiet, "No progress and no notes on standard error"});
  if (!command.method.empty())
    command.options.push_back(
        {"--verbose", &manner().verbose, "Whole ids, and times in UTC, on a terminal too"});
}

// ---- Help ----

std::size_t help_width() {
  constexpr std::size_t kElsewhere = 100;  // in a file, a pipe or a man page
  const std::size_t columns = columns_of(STDOUT_FILENO);
  return columns == 0 ? kElsewhere : columns;
}

void print_help(const CommandLine& line, const std::string& command) {
  const Command* const named = find_command(line, command);
  std::fputs(help_text(line, named, help_width()).c_str(), stdout);
}

/// "truepose calibrate --help"
std::string help_of(const std::string& command) {
  return "truepose " + command + (command.empty() ? "" : " ") + "--help";
}

/// The help of the command that the words name.
int run_help(const CommandLine& line, const std::vector<std::string>& words) {
  std::string name;
  for (const std::string& word : words) {
    std::vector<std::string> known;
    for (const Command& command : line.commands)
      if (command.name.starts_with(name)) known.push_back(command.name.substr(name.size()));
    if (std::ranges::find(known, word) == known.end())
      throw CommandError{kBadInput, "help: " + config::in_quotes(word) + " is no command" +
                                        (name.empty() ? "" : " of " + name.substr(0, name.size() - 1)) +
                                        config::suggestion(word, known)};
    name += word + " ";
  }
  print_help(line, name.substr(0, name.size() - std::min<std::size_t>(name.size(), 1)));
  return kDone;
}

/// Where words are missing that name a command, its help is the answer.
bool lacks_command(const CLI::App& app, const CLI::App& last, const CLI::ParseError& error) {
  return dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && app.remaining(true).empty() &&
         !last.get_subcommands([](const CLI::App*) { return true; }).empty();
}

int run_words(const CommandLine& line, std::vector<std::string> words) {
  int exit_code = kDone;
  CLI::App app{"", "truepose"};
  app.set_version_flag("-V,--version", daemon::version_text("truepose"));
  app.require_subcommand(1);
  add_options(app, line.options);
  for (const Command& command : line.commands) add_command(app, command, line.options, exit_code);
  try {
    std::ranges::reverse(words);  // as CLI11 takes them
    app.parse(std::move(words));
  } catch (const CLI::ParseError& error) {
    const CLI::App& command = innermost(app);
    const bool asks_for_help = dynamic_cast<const CLI::CallForHelp*>(&error) != nullptr;
    if (!asks_for_help && error.get_exit_code() == 0) return app.exit(error);  // --version
    if (asks_for_help || lacks_command(app, command, error)) {
      print_help(line, command_name(command));
      return asks_for_help ? kDone : kBadInput;
    }
    throw CommandError{kBadInput, usage_fault(command, error), help_of(command_name(command))};
  } catch (CommandError& error) {
    if (!error.see.empty()) error.see = help_of(command_name(innermost(app)));
    throw;
  }
  return exit_code;
}

}  // namespace

CommandError bad_usage(const std::string& message) { return {kBadInput, message, help_of("")}; }

void flush_standard_output() {
  errno = 0;
  std::cout.flush();
  std::fflush(stdout);
  const std::string why = errno == 0 ? "" : std::string{": "} + std::strerror(errno);
  if (!std::cout || std::ferror(stdout) != 0)
    throw CommandError{kBadInput, "standard output cannot be written" + why};
}

void print_to_stderr(const std::string& sentence) {
  if (!manner().quiet) print_line(sentence);
}

int run_command_line(const CommandLine& given, std::vector<std::string> words) {
  CommandLine line = given;
  manner() = {};
  for (Command& command : line.commands) add_manner(command);
  std::vector<std::string> topic;
  line.commands.push_back({.name = "help",
                           .help = "Shows the help of a command",
                           .options = {{"COMMAND", &topic, "Such as campaign start", {.type = "COMMAND.."}}},
                           .run = [&] { return run_help(line, topic); },
                           .examples = {{"help calibrate"}, {"help campaign start"}}});
  if (!words.empty() && words.front() == "__complete") {  // called by completion/truepose.bash and _truepose
    for (const Option& option : line.options) take_from_environment(option);
    words.erase(words.begin());
    std::fputs(completions(line, words).c_str(), stdout);
    return kDone;
  }
  const bool as_json = std::ranges::find(words, "--json") != words.end();
  const int ended = exit_code_as(as_json, [&] { return run_words(line, std::move(words)); });
  if (ended > kFailed) return ended;  // says already why nothing can be relied on
  return exit_code_as(as_json, [ended] {
    flush_standard_output();
    return ended;
  });
}

int exit_code_of(const std::function<int()>& work) { return exit_code_as(false, work); }

}  // namespace truepose::tools
