#include "proto/krl/variables.hpp"

#include <algorithm>
#include <cmath>

namespace truepose::krl {
namespace {

bool is_any_of(const Token& token, std::initializer_list<std::string_view> words) {
  return std::ranges::any_of(words, [&](std::string_view word) { return token.is(word); });
}

std::optional<VariableType> type_of(const Token& token) {
  if (is_any_of(token, {"E6POS", "POS", "E6AXIS", "AXIS"})) return VariableType::Position;
  if (token.is("FRAME")) return VariableType::Frame;
  if (token.is("FDAT")) return VariableType::MotionData;
  return std::nullopt;
}

std::size_t behind_brackets(Tokens tokens, std::size_t from) {
  std::size_t i = from;
  while (i < tokens.size() && !tokens[i].is(']')) ++i;
  return std::min(i + 1, tokens.size());
}

/// Routines of the controller that take a position and leave it as it is.
bool leaves_arguments(const Token& routine) { return is_any_of(routine, {"FORWARD", "INVERSE", "INV_POS"}); }

using Kind = HindranceKind;

void hinder(Variable& variable, Message why, Spot because) {
  if (!variable.hindrance) variable.hindrance = Hindrance{std::move(why), because};
}

/// "3" or "2,1" of `[3]` or `[2,1]`; nothing where an index is no plain number, or more stands there.
std::optional<std::string> plain_indices(Tokens brackets) {
  if (brackets.size() < 3 || !brackets[0].is('[') || !brackets.back().is(']')) return std::nullopt;
  std::string indices;
  for (std::size_t i = 1; i + 1 < brackets.size(); ++i) {
    const bool is_index = i % 2 == 1;
    if (is_index ? brackets[i].kind != TokenKind::Number : !brackets[i].is(',')) return std::nullopt;
    indices += brackets[i].text;
  }
  return brackets.size() % 2 == 1 ? std::optional{indices} : std::nullopt;
}

/// The text from the first of these tokens to the last.
std::string_view whole_name(Tokens variable) {
  return {variable[0].text.data(), variable.back().end() - variable[0].at};
}

std::optional<int> whole(const Field* field) {
  if (!field || !field->number) return std::nullopt;
  const double value = field->number->value;
  if (value != std::trunc(value) || std::abs(value) > 1e6) return std::nullopt;
  return static_cast<int>(value);
}

}  // namespace

Tokens action_of(Tokens statement) {
  const bool is_global = statement.size() > 1 && statement[0].is("GLOBAL");
  if (!is_any_of(statement[is_global ? 1 : 0], {"TRIGGER", "INTERRUPT"})) return statement;
  const auto found = std::ranges::find_if(statement, [](const Token& token) { return token.is("DO"); });
  return found == statement.end() ? Tokens{} : Tokens(found + 1, statement.end());
}

bool starts_routine(Tokens statement) {
  if (statement[0].is("GLOBAL")) statement = statement.subspan(1);
  return !statement.empty() && is_any_of(statement[0], {"DEF", "DEFFCT"});
}

MotionData motion_data_of(const Aggregate& aggregate) {
  const Field* frame = aggregate.find("IPO_FRAME");
  return {.tool = whole(aggregate.find("TOOL_NO")),
          .base = whole(aggregate.find("BASE_NO")),
          .fixed_tool = frame && in_capitals(frame->word) == "#TCP"};
}

std::size_t end_of_variable(Tokens tokens, std::size_t from) {
  std::size_t i = from + 1;
  while (i < tokens.size()) {
    if (tokens[i].is('[')) {
      i = behind_brackets(tokens, i);
    } else if (tokens[i].is('.') && i + 1 < tokens.size() && tokens[i + 1].kind == TokenKind::Name) {
      i += 2;
    } else {
      break;
    }
  }
  return i;
}

std::optional<std::size_t> Variables::find(std::string_view name, Scope scope) const {
  const std::string key = in_capitals(name), module{scope.module};
  for (const auto& [of_module, of_routine] : {std::pair{module, scope.routine}, {module, 0UZ}, {"", 0UZ}}) {
    if (const auto found = names_.find({of_module, of_routine, key}); found != names_.end())
      return found->second;
  }
  return std::nullopt;
}

std::optional<std::size_t> Variables::find_element(Tokens element, Scope scope) const {
  const auto array = find(element[0].text, scope);
  const auto indices = plain_indices(element.subspan(1));
  if (!array || !indices) return std::nullopt;
  const auto found = elements_.find({*array, *indices});
  return found == elements_.end() ? std::nullopt : std::optional{found->second};
}

Variables::Reading Variables::reading_of(const SourceText& source, std::size_t file) {
  return {.file = file,
          .scope = {source.module},
          .is_config = source.role == SourceText::Role::Config,
          .is_program = source.role == SourceText::Role::Program};
}

std::expected<void, Fault> Variables::read_declarations(const SourceText& source, std::size_t file) {
  StatementReader reader(source.text);
  Reading reading = reading_of(source, file);
  while (true) {
    const auto statement = reader.next();
    if (!statement) return std::unexpected(statement.error());
    if (statement->empty()) return {};
    if (starts_routine(*statement)) {
      ++reading.scope.routine;
    } else if (const auto done = read_declaration(*statement, reading); !done) {
      return done;
    }
  }
}

std::expected<void, Fault> Variables::read_uses(const SourceText& source, std::size_t file) {
  StatementReader reader(source.text);
  Reading reading = reading_of(source, file);
  while (true) {
    const auto statement = reader.next();
    if (!statement) return std::unexpected(statement.error());
    if (statement->empty()) return {};
    if (starts_routine(*statement)) {
      ++reading.scope.routine;
      continue;
    }
    const Tokens action = action_of(*statement);
    if (const auto done = read_assignment(action, reading); !done) return done;
    read_arguments(action, reading);
    if (reading.is_program) read_chosen_elements(action, reading);
  }
}

std::expected<void, Fault> Variables::read_declaration(Tokens statement, const Reading& reading) {
  std::size_t i = 0;
  bool is_global = reading.is_config;
  for (; i < statement.size() && is_any_of(statement[i], {"DECL", "GLOBAL", "CONST"}); ++i)
    is_global |= statement[i].is("GLOBAL");
  if (i + 1 >= statement.size() || statement[i + 1].kind != TokenKind::Name) return {};
  const auto type = type_of(statement[i]);
  if (!type) return {};
  const std::string module{reading.scope.module};
  for (++i; i < statement.size() && statement[i].kind == TokenKind::Name; ++i) {
    const Token& name = statement[i];
    if (is_any_of(name, {"TOOL_DATA", "BASE_DATA"})) return {};  // frames, and no positions
    const std::string key = in_capitals(name.text);
    const auto [entry, is_new] = names_.try_emplace({module, reading.scope.routine, key}, variables_.size());
    if (!is_new)
      return std::unexpected(Fault{name.at, std::string(name.text) + " is declared twice; remove one"});
    if (is_global) names_.try_emplace({"", 0, key}, variables_.size());
    Variable& variable = variables_.emplace_back(Variable{
        .name = name.text, .type = *type, .declared = {reading.file, name.at}, .value = {}, .hindrance = {}});
    ++i;
    if (i < statement.size() && statement[i].is('[')) {
      variable.array = true;
      i = behind_brackets(statement, i);
    }
    if (i < statement.size() && statement[i].is('=')) {
      // A further variable behind a value is not KRL.
      return give_value(variable, statement.subspan(i + 1), {reading.file, name.at});
    }
    if (i >= statement.size() || !statement[i].is(',')) return {};
  }
  return {};
}

std::expected<void, Fault> Variables::give_value(Variable& variable, Tokens value, Spot spot) {
  if (value.empty() || !value[0].is('{')) {
    hinder(variable, message<Kind::Computed>("is"), spot);
    return {};
  }
  std::size_t next = 0;
  const auto aggregate = read_aggregate(value, next);
  if (!aggregate) return std::unexpected(aggregate.error());
  if (next != value.size()) {
    hinder(variable, message<Kind::Computed>("is"), spot);
  } else if (variable.type == VariableType::MotionData) {
    variable.value = motion_data_of(*aggregate);
  } else if (auto position = position_of(*aggregate, spot.file)) {
    variable.value = *position;
  } else {
    hinder(variable, position.error(), spot);
  }
  return {};
}

std::expected<void, Fault> Variables::read_assignment(Tokens statement, const Reading& reading) {
  if (statement.empty() || statement[0].kind != TokenKind::Name) return {};
  const std::size_t end = end_of_variable(statement, 0);
  if (end >= statement.size() || !statement[end].is('=')) return {};
  const Spot spot{reading.file, statement[0].at};
  if (reading.is_program && is_any_of(statement[0], {"TOOL_DATA", "BASE_DATA"}))
    read_frame_write(statement.first(end), reading);
  const auto index = find(statement[0].text, reading.scope);
  if (!index) return {};
  if (variables_[*index].array) return give_element(*index, statement, end, spot);
  Variable& variable = variables_[*index];
  if (end > 1) {
    hinder(variable, message<Kind::Changed>("is changed"), spot);
  } else if (!std::holds_alternative<std::monostate>(variable.value)) {
    hinder(variable, message<Kind::Changed>("is given another value"), spot);
  } else {
    return give_value(variable, statement.subspan(end + 1), spot);
  }
  return {};
}

/// `WORK[3]={X ..}`, which is a variable of its own from there on, or a change of elements.
std::expected<void, Fault> Variables::give_element(std::size_t array, Tokens assignment, std::size_t end,
                                                   Spot spot) {
  const std::size_t last = behind_brackets(assignment, 1);
  const auto indices = plain_indices(assignment.subspan(1, last - 1));
  if (!indices) {
    hinder_elements(array, message<Kind::Changed>("may be given another value"), spot);
    return {};
  }
  const auto [entry, is_new] = elements_.try_emplace({array, *indices}, variables_.size());
  if (!is_new) {
    hinder(variables_[entry->second],
           message<Kind::Changed>(last < end ? "is changed" : "is given another value"), spot);
    return {};
  }
  const Variable whole = variables_[array];
  const std::string_view name = whole_name(assignment.first(last));
  Variable& element = variables_.emplace_back(Variable{.name = name,
                                                       .type = whole.type,
                                                       .declared = spot,
                                                       .is_element = true,
                                                       .value = {},
                                                       .hindrance = whole.hindrance});
  if (last == end) return give_value(element, assignment.subspan(end + 1), spot);
  hinder(element, message<Kind::Changed>("is changed"), spot);
  return {};
}

/// All elements of an array, also those that get their value later.
void Variables::hinder_elements(std::size_t array, const Message& why, Spot spot) {
  hinder(variables_[array], why, spot);
  for (auto element = elements_.lower_bound({array, ""});
       element != elements_.end() && element->first.first == array; ++element)
    hinder(variables_[element->second], why, spot);
}

/// A motion to an element whose index is computed may go to any of them, with whatever frames.
void Variables::read_chosen_elements(Tokens statement, const Reading& reading) {
  for (std::size_t i = 0; i + 1 < statement.size(); ++i) {
    if (statement[i].kind != TokenKind::Name || !statement[i + 1].is('[')) continue;
    const std::size_t end = behind_brackets(statement, i + 1);
    const auto index = find(statement[i].text, reading.scope);
    const bool is_of_points =
        index && variables_[*index].array && variables_[*index].type != VariableType::MotionData;
    if (is_of_points && !plain_indices(statement.subspan(i + 1, end - i - 1)))
      hinder_elements(*index, message<Kind::Index>(), {reading.file, statement[i].at});
  }
}

void Variables::read_frame_write(Tokens variable, const Reading& reading) {
  std::optional<int> index;
  if (variable.size() >= 4 && variable[1].is('[') && variable[3].is(']')) {
    const auto number = read_number(variable.subspan(2, 1));
    if (number && *number && (*number)->value <= 1e6) index = static_cast<int>((*number)->value);
  }
  frame_writes_.emplace(std::tuple{std::string(reading.scope.module), in_capitals(variable[0].text), index},
                        Spot{reading.file, variable[0].at});
}

std::optional<Spot> Variables::frame_written(std::string_view module, std::string_view table,
                                             int number) const {
  for (const std::optional<int> index : {std::optional(number), std::optional<int>{}}) {
    const auto found = frame_writes_.find({std::string(module), std::string(table), index});
    if (found != frame_writes_.end()) return found->second;
  }
  return std::nullopt;
}

void Variables::read_arguments(Tokens statement, const Reading& reading) {
  // Innermost routine whose arguments are being read, by its name's index; none for a mere bracket.
  std::vector<std::optional<std::size_t>> routines;
  for (std::size_t i = 0; i < statement.size(); ++i) {
    const Token& token = statement[i];
    if (token.is('(')) {
      const bool is_call = i > 0 && statement[i - 1].kind == TokenKind::Name;
      routines.push_back(is_call ? std::optional(i - 1) : std::nullopt);
    } else if (token.is(')') && !routines.empty()) {
      routines.pop_back();
    } else if (token.kind == TokenKind::Name && !routines.empty() && routines.back()) {
      const Token& called = statement[*routines.back()];
      const bool is_whole = (statement[i - 1].is('(') || statement[i - 1].is(',')) &&
                            i + 1 < statement.size() &&
                            (statement[i + 1].is(')') || statement[i + 1].is(','));
      if (!is_whole || leaves_arguments(called)) continue;
      const auto index = find(token.text, reading.scope);
      // An inline form hands its FDAT to routines of the controller, which leave it as it is.
      if (!index || variables_[*index].type == VariableType::MotionData) continue;
      hinder(variables_[*index], message<Kind::Argument>(called.text), {reading.file, token.at});
    }
  }
}

}  // namespace truepose::krl
