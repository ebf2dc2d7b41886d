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

void hinder(Variable& variable, std::string why, Spot because) {
  if (!variable.hindrance) variable.hindrance = Hindrance{std::move(why), because};
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

std::optional<std::size_t> Variables::find(std::string_view name, std::size_t routine) const {
  const std::string key = in_capitals(name);
  for (const std::size_t scope : {routine, 0UZ}) {
    if (scope >= scopes_.size()) continue;
    if (const auto found = scopes_[scope].find(key); found != scopes_[scope].end()) return found->second;
  }
  return std::nullopt;
}

std::expected<void, Fault> Variables::read(std::string_view text, File file) {
  StatementReader reader(text);
  std::size_t routine = 0;
  while (true) {
    const auto statement = reader.next();
    if (!statement) return std::unexpected(statement.error());
    if (statement->empty()) return {};
    if (starts_routine(*statement)) {
      ++routine;
      continue;
    }
    if (const auto done = read_declaration(*statement, file, routine); !done)
      return std::unexpected(done.error());
    const Tokens action = action_of(*statement);
    if (const auto done = read_assignment(action, file, routine); !done) return std::unexpected(done.error());
    read_arguments(action, file, routine);
  }
}

std::expected<void, Fault> Variables::read_declaration(Tokens statement, File file, std::size_t routine) {
  std::size_t i = 0;
  while (i < statement.size() && is_any_of(statement[i], {"DECL", "GLOBAL", "CONST"})) ++i;
  if (i + 1 >= statement.size() || statement[i + 1].kind != TokenKind::Name) return {};
  const auto type = type_of(statement[i]);
  if (!type) return {};
  while (scopes_.size() <= routine) scopes_.emplace_back();
  for (++i; i < statement.size() && statement[i].kind == TokenKind::Name; ++i) {
    const Token& name = statement[i];
    const auto [entry, is_new] = scopes_[routine].emplace(in_capitals(name.text), variables_.size());
    if (!is_new)
      return std::unexpected(Fault{name.at, std::string(name.text) + " is declared twice; remove one"});
    Variable& variable = variables_.emplace_back(Variable{
        .name = name.text, .type = *type, .declared = {file, name.at}, .value = {}, .hindrance = {}});
    ++i;
    if (i < statement.size() && statement[i].is('[')) {
      variable.array = true;
      i = behind_brackets(statement, i);
    }
    if (i < statement.size() && statement[i].is('=')) {
      // A further variable behind a value is not KRL.
      return give_value(variable, statement.subspan(i + 1), {file, name.at});
    }
    if (i >= statement.size() || !statement[i].is(',')) return {};
  }
  return {};
}

std::expected<void, Fault> Variables::give_value(Variable& variable, Tokens value, Spot spot) {
  if (value.empty() || !value[0].is('{')) {
    hinder(variable, "is computed by the program", spot);
    return {};
  }
  std::size_t next = 0;
  const auto aggregate = read_aggregate(value, next);
  if (!aggregate) return std::unexpected(aggregate.error());
  if (next != value.size()) {
    hinder(variable, "is computed by the program", spot);
  } else if (variable.type == VariableType::MotionData) {
    variable.value = motion_data_of(*aggregate);
  } else if (auto position = position_of(*aggregate, spot.file)) {
    variable.value = *position;
  } else {
    hinder(variable, position.error(), spot);
  }
  return {};
}

std::expected<void, Fault> Variables::read_assignment(Tokens statement, File file, std::size_t routine) {
  if (statement.empty() || statement[0].kind != TokenKind::Name) return {};
  const std::size_t end = end_of_variable(statement, 0);
  if (end >= statement.size() || !statement[end].is('=')) return {};
  const Spot spot{file, statement[0].at};
  if (file == File::Src && is_any_of(statement[0], {"TOOL_DATA", "BASE_DATA"}))
    read_frame_write(statement.first(end), spot);
  const auto index = find(statement[0].text, routine);
  if (!index) return {};
  Variable& variable = variables_[*index];
  if (variable.array) return {};
  if (end > 1) {
    hinder(variable, "is changed by the program", spot);
  } else if (!std::holds_alternative<std::monostate>(variable.value)) {
    hinder(variable, "is given another value by the program", spot);
  } else {
    return give_value(variable, statement.subspan(end + 1), spot);
  }
  return {};
}

void Variables::read_frame_write(Tokens variable, Spot spot) {
  std::optional<int> index;
  if (variable.size() >= 4 && variable[1].is('[') && variable[3].is(']')) {
    const auto number = read_number(variable.subspan(2, 1));
    if (number && *number && (*number)->value <= 1e6) index = static_cast<int>((*number)->value);
  }
  frame_writes_.emplace(std::pair{in_capitals(variable[0].text), index}, spot);
}

std::optional<Spot> Variables::frame_written(std::string_view table, int number) const {
  for (const std::optional<int> index : {std::optional(number), std::optional<int>{}}) {
    const auto found = frame_writes_.find({std::string(table), index});
    if (found != frame_writes_.end()) return found->second;
  }
  return std::nullopt;
}

void Variables::read_arguments(Tokens statement, File file, std::size_t routine) {
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
      const auto index = find(token.text, routine);
      // An inline form hands its FDAT to routines of the controller, which leave it as it is.
      if (!index || variables_[*index].type == VariableType::MotionData) continue;
      hinder(variables_[*index], "is handed to " + std::string(called.text) + ", which may change it",
             {file, token.at});
    }
  }
}

}  // namespace truepose::krl
