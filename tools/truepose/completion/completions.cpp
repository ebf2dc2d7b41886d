#include "tools/truepose/completion/completions.hpp"

#include <algorithm>

#include "tools/truepose/help_text.hpp"
#include "tools/truepose/option_names.hpp"

namespace truepose::tools {
namespace {

/// What the words before the last one say.
struct Typed {
  std::string name;                  ///< of the command or the group
  const Command* command = nullptr;  ///< null: none yet
  const Option* awaits = nullptr;    ///< whose value comes next
  std::vector<std::string> given{};  ///< options by their names
  std::size_t places = 0;            ///< words that are no option
};

class Lines {
 public:
  explicit Lines(std::string start) : start_{std::move(start)} {}
  void add(const std::string& word, const std::string& what) {
    if (word.starts_with(start_)) text_ += word + '\t' + what.substr(0, what.find('\n')) + '\n';
  }
  void add_names_of(const char* what) { text_ += ':' + std::string{what} + '\n'; }
  std::string text() && { return std::move(text_); }

 private:
  std::string start_, text_;
};

const std::vector<Option>& options_of(const CommandLine& line, const Typed& typed) {
  return typed.command ? typed.command->options : line.options;
}

const Option* option_called(const std::vector<Option>& options, const std::string& word) {
  const auto found = std::ranges::find_if(
      options, [&](const Option& option) { return option.name == word || short_name(option.name) == word; });
  return found == options.end() ? nullptr : &*found;
}

Typed read(const CommandLine& line, const std::vector<std::string>& words) {
  Typed typed;
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "=") continue;  // bash has --robot=arm.yaml in three words
    if (typed.awaits) {
      typed.awaits = nullptr;
    } else if (word.starts_with('-')) {
      const Option* const option = option_called(options_of(line, typed), word);
      if (option == nullptr) continue;
      typed.given.push_back(option->name);
      if (!is_flag(*option)) typed.awaits = option;
    } else if (!typed.command || !typed.command->run) {
      typed.name += (typed.name.empty() ? "" : " ") + word;
      typed.command = find_command(line, typed.name);
      if (!typed.command) return typed;
    } else {
      ++typed.places;
    }
  }
  return typed;
}

void add_commands(const CommandLine& line, const std::string& group, Lines& lines) {
  const std::string start = group.empty() ? "" : group + " ";
  for (const Command& command : line.commands) {
    if (!command.name.starts_with(start)) continue;
    const std::string rest = command.name.substr(start.size());
    if (!rest.contains(' ')) lines.add(rest, command.help);
  }
}

void add_values(const Option& option, Lines& lines) {
  if (option.rules.check)
    for (const std::string& value : option.rules.check->values) lines.add(value, option.name);
  if (option.rules.candidates)
    for (const std::string& value : option.rules.candidates()) lines.add(value, option.rules.id_of);
  const std::string kind = kind_of(option);
  if (kind.contains("FILE") || kind.contains("ZIP"))
    lines.add_names_of("files");
  else if (kind.contains("DIR"))
    lines.add_names_of("dirs");
}

void add_options(const std::vector<Option>& options, Lines& lines) {
  for (const Option& option : options) {
    if (!has_dashes(option)) continue;
    lines.add(option.name, option.help);
    if (const std::string no = negated_name(option); !no.empty()) lines.add(no, option.help);
  }
  lines.add("--help", "Print the help");
}

/// The option that the next word without a name is for; null: none.
const Option* option_by_place(const Typed& typed) {
  std::size_t place = 0;
  const Option* last = nullptr;
  for (const Option& option : typed.command->options) {
    if (!goes_by_place(option) || std::ranges::find(typed.given, option.name) != typed.given.end()) continue;
    last = &option;
    if (place++ == typed.places) return last;
  }
  const bool takes_more = last && std::holds_alternative<std::vector<std::string>*>(last->target);
  return takes_more && !last->rules.repeats ? last : nullptr;
}

}  // namespace

std::string completions(const CommandLine& line, const std::vector<std::string>& words) {
  const std::string last = words.empty() || words.back() == "=" ? "" : words.back();
  const Typed typed = read(line, words);
  Lines lines{last};
  if (typed.name.starts_with("help")) {
    std::string group;
    for (std::size_t i = 1; i + 1 < words.size(); ++i) group += (i > 1 ? " " : "") + words[i];
    add_commands(line, group, lines);
  } else if (typed.awaits) {
    add_values(*typed.awaits, lines);
  } else if (last.starts_with('-')) {
    add_options(options_of(line, typed), lines);
  } else if (!typed.command ? typed.name.empty() : !typed.command->run) {
    add_commands(line, typed.name, lines);
  } else if (typed.command) {
    if (const Option* const option = option_by_place(typed)) add_values(*option, lines);
  }
  return std::move(lines).text();
}

}  // namespace truepose::tools
