#include "tools/truepose/help_text.hpp"

#include <algorithm>
#include <array>
#include <type_traits>

#include "config/number_text.hpp"
#include "tools/truepose/option_names.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

constexpr std::size_t kNames = 28;       ///< columns of names, before what they mean
constexpr std::size_t kShownInKind = 3;  ///< so many values stand in place of a kind: "deg|rad"

struct TaskTitle {
  Task task;
  std::string_view title;
};
constexpr std::array kTasks{TaskTitle{Task::Files, "Commands on files, without a daemon"},
                            TaskTitle{Task::Daemon, "Commands to measure and correct, of the daemon"},
                            TaskTitle{Task::Cell, "Commands to set a cell up and keep it"},
                            TaskTitle{Task::Diagnosis, "Commands to find out what is wrong"}};

/// A row: names, and what they mean from the column kNames on.
std::string row(const std::string& names, const std::string& meaning, std::size_t width) {
  const std::string start = "  " + names;
  const std::string text = wrapped(meaning, width, kNames);
  if (start.size() + 2 > kNames) return start + '\n' + std::string(kNames, ' ') + text + '\n';
  return start + std::string(kNames - start.size(), ' ') + text + '\n';
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

std::string joined(const std::vector<std::string>& words, const char* last) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? std::string{" "} + last + " " : ", ") + words[i];
  return text;
}

std::string default_text(const Option& option) {
  return std::visit(
      []<class T>(const T* value) -> std::string {
        if constexpr (std::same_as<T, std::string>) return *value;
        if constexpr (std::same_as<T, double>) return config::format_number(*value);
        if constexpr (std::is_integral_v<T> && !std::same_as<T, bool>) return std::to_string(*value);
        return {};
      },
      option.target);
}

/// Those that it excludes, and those that exclude it.
std::vector<std::string> excluded_by(const Option& option, const std::vector<Option>& all) {
  std::vector<std::string> names = option.rules.excludes;
  for (const Option& other : all)
    if (has(other.rules.excludes, option.name) && !has(names, other.name)) names.push_back(other.name);
  return names;
}

/// What it means, then what its value may be and with which others it goes, a sentence each.
std::string meaning_of(const Option& option, const std::vector<Option>& all) {
  const OptionRules& rules = option.rules;
  std::string text = option.help;
  const auto add = [&](const std::string& sentence) {
    text += (text.ends_with('.') ? " " : ". ") + sentence + ".";
  };
  if (rules.check && !rules.check->shown.empty()) add(rules.check->shown);
  if (rules.check && rules.check->values.size() > kShownInKind)
    add("One of " + joined(rules.check->values, "or"));
  if (const std::string value = default_text(option); rules.shows_default && !value.empty())
    add("Default: " + value);
  if (!rules.id_of.empty()) add("Its id, the start of it, or latest");
  if (!rules.environment.empty()) add("Without it: what " + rules.environment + " says");
  if (rules.repeats) add("May be given again");
  if (!rules.needs.empty()) add("Needs " + joined(rules.needs, "and"));
  if (const auto names = excluded_by(option, all); !names.empty()) add("Not with " + joined(names, "or"));
  return text;
}

/// "-o, --out FILE"
std::string names_of(const Option& option) {
  std::string names = name_of_place(option);
  const auto add = [&](std::string_view name) { (names += names.empty() ? "" : ", ") += name; };
  if (has_dashes(option)) {
    if (const std::string_view letter = short_name(option.name); !letter.empty()) add(letter);
    add(option.name);
    if (const std::string no = negated_name(option); !no.empty()) add(no);
    if (!is_flag(option)) names += " " + kind_of(option);
  }
  return names;
}

std::string usage_of(const Command& command) {
  std::string usage = "truepose " + command.name;
  if (!command.run) return usage + " COMMAND";
  std::vector<std::string> subjects;
  for (const Option& option : command.options) {
    if (goes_by_place(option)) {
      const std::string name = name_of_place(option);
      usage += option.rules.required ? " " + name : " [" + name + "]";
    } else if (option.rules.required) {
      usage += " " + option.name + " " + kind_of(option);
    } else if (option.rules.is_subject) {
      subjects.push_back(option.name + " " + kind_of(option));
    }
  }
  for (std::size_t i = 0; i < subjects.size(); ++i)
    usage += (i == 0 ? " (" : " | ") + subjects[i] + (i + 1 == subjects.size() ? ")" : "");
  return usage + " [OPTIONS]";
}

std::string section(std::string_view title, const std::string& rows) {
  return rows.empty() ? "" : "\n" + std::string{title} + ":\n" + rows;
}

bool is_in_group(const Command& command, const std::string& group) {
  return command.name.size() > group.size() && command.name.starts_with(group + " ");
}

std::string examples_text(const std::vector<Example>& examples, std::size_t width) {
  std::string text;
  for (const auto& [line, what] : examples) {
    text += "  truepose " + line + "\n";
    if (!what.empty()) text += "      " + wrapped(what, width, 6) + "\n";
  }
  return text;
}

/// Of a group: the first of each of its commands. A command that needs nothing is its own example.
std::vector<Example> examples_of(const CommandLine& line, const Command& command) {
  if (!command.examples.empty()) return command.examples;
  if (command.run) return {{command.name, ""}};
  constexpr std::size_t kMost = 4;
  std::vector<Example> examples;
  for (const Command& other : line.commands)
    if (is_in_group(other, command.name) && examples.size() < kMost)
      examples.push_back(examples_of(line, other).front());
  return examples;
}

std::string command_help(const CommandLine& line, const Command& command, std::size_t width) {
  std::string commands, places, options, connection, subjects;
  for (const Command& other : line.commands)
    if (is_in_group(other, command.name))
      commands += row(other.name.substr(command.name.size() + 1), other.help, width);
  for (const Option& option : command.options) {
    const bool is_connection =
        std::ranges::find(line.options, option.name, &Option::name) != line.options.end();
    std::string& rows = goes_by_place(option)     ? places
                        : option.rules.is_subject ? subjects
                        : is_connection           ? connection
                                                  : options;
    rows += row(names_of(option), meaning_of(option, command.options), width);
  }
  options += row("-h, --help", "Print this help", width);
  return wrapped(command.help, width, 0) + ".\nUsage: " + wrapped(usage_of(command), width, 7) + "\n" +
         section("Examples", examples_text(examples_of(line, command), width)) +
         section("Commands", commands) + section("Arguments", places) +
         section(command.subjects + " (one of these)", subjects) + section("Options", options) +
         section("Which daemon", connection);
}

std::string program_help(const CommandLine& line, std::size_t width) {
  std::string text =
      "Calibrates industrial robots with a laser tracker, and corrects them while they work.\n"
      "Usage: truepose COMMAND [OPTIONS]\n";
  text += section("Start here, with the files of /usr/share/truepose/quickstart",
                  examples_text({{"calibrate arm.yaml points.csv --split 0.7 -o model.yaml"},
                                 {"compensate arm.yaml model.yaml --poses targets.csv"}},
                                width));
  text += section("Start here, with a cell",
                  examples_text({{"cell demo", "A simulated one, measured and calibrated"},
                                 {"doctor cell.yaml"},
                                 {"campaign start --watch"}},
                                width));
  for (const auto& [task, title] : kTasks) {
    std::string rows;
    for (const Command& command : line.commands)
      if (command.task == task && !command.name.contains(' ')) rows += row(command.name, command.help, width);
    text += section(title, rows);
  }
  std::string options = row("-h, --help", "Print this help", width) +
                        row("-V, --version", "Print the version, and those of its libraries", width);
  for (const Option& option : line.options)
    options += row(names_of(option), meaning_of(option, line.options), width);
  return text + section("Options", options) +
         "\ntruepose help COMMAND shows options and examples of a command, man truepose more.\n";
}

}  // namespace

std::string kind_of(const Option& option) {
  const OptionRules& rules = option.rules;
  if (!rules.type.empty()) return rules.type;
  if (rules.file != FileUse::None) return "FILE";
  const auto& values = rules.check ? rules.check->values : std::vector<std::string>{};
  if (!values.empty() && values.size() <= kShownInKind) {
    std::string all;
    for (const std::string& value : values) all += (all.empty() ? "" : "|") + value;
    return all;
  }
  return std::visit(
      []<class T>(const T*) -> std::string {
        if constexpr (std::same_as<T, bool> || std::same_as<T, std::optional<bool>>) return "";
        if constexpr (std::same_as<T, double> || std::same_as<T, std::optional<double>>) return "NUMBER";
        if constexpr (std::same_as<T, std::vector<double>>) return "NUMBER,..";
        if constexpr (std::same_as<T, std::vector<int>>) return "N,..";
        if constexpr (std::same_as<T, std::vector<std::string>>) return "NAME,..";
        if constexpr (std::same_as<T, std::string> || std::same_as<T, std::filesystem::path>) return "NAME";
        return "N";
      },
      option.target);
}

std::string name_of_place(const Option& option) {
  if (!option.rules.place.empty()) return option.rules.place;
  if (has_dashes(option)) return {};
  return option.rules.type.empty() ? option.name : option.rules.type;
}

const Command* find_command(const CommandLine& line, const std::string& name) {
  const auto found = std::ranges::find(line.commands, name, &Command::name);
  return found == line.commands.end() ? nullptr : &*found;
}

std::string help_text(const CommandLine& line, const Command* command, std::size_t width) {
  return command == nullptr ? program_help(line, width) : command_help(line, *command, width);
}

}  // namespace truepose::tools
