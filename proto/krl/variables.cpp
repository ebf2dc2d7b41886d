#include "proto/krl/variables.hpp"

#include <algorithm>

namespace truepose::krl {
namespace {

VariableType type_of(const Token& token) {
  if (token.is("FRAME")) return VariableType::Frame;
  return token.is("FDAT") ? VariableType::MotionData : VariableType::Position;
}

using Kind = HindranceKind;

void hinder(Variable& variable, Message why, Spot because) {
  if (!variable.hindrance) variable.hindrance = std::make_shared<Hindrance>(std::move(why), because);
}

/// NAME, NAME[1] or NAME.X, of which the variable is a part or which it is itself.
const Expression& nearest(const Expression& variable) {
  const bool is_nearest = variable.parts.empty() || variable.parts[0].kind == ExpressionKind::Name;
  return is_nearest ? variable : nearest(variable.parts[0]);
}

/// "3" or "2,1" of NAME[3] or NAME[2,1]; nothing where an index is no plain number.
std::optional<std::string> plain_indices(const Expression& element) {
  if (element.kind != ExpressionKind::Element || element.parts[0].kind != ExpressionKind::Name)
    return std::nullopt;
  std::string indices;
  for (std::size_t i = 1; i < element.parts.size(); ++i) {
    if (element.parts[i].token.kind != TokenKind::Integer) return std::nullopt;
    indices += (i > 1 ? "," : "") + std::string(element.parts[i].text());
  }
  return indices;
}

bool is_frame_table(std::string_view name) { return name == "TOOL_DATA" || name == "BASE_DATA"; }

void give_value(Variable& variable, const Expression& value, Spot spot) {
  if (value.kind != ExpressionKind::Aggregate) return hinder(variable, message<Kind::Computed>("is"), spot);
  if (variable.type == VariableType::MotionData) {
    variable.value = motion_data_of(value);
  } else if (auto position = position_of(value, spot.file)) {
    variable.value = *position;
  } else {
    hinder(variable, position.error(), spot);
  }
}

}  // namespace

MotionData motion_data_of(const Expression& aggregate) {
  const auto index = [&](std::string_view name) {
    const Expression* value = aggregate.find(name);
    return value ? index_of(*value) : std::nullopt;
  };
  const Expression* frame = aggregate.find("IPO_FRAME");
  return {.tool = index("TOOL_NO"),
          .base = index("BASE_NO"),
          .fixed_tool = frame && frame->kind == ExpressionKind::Literal && frame->name == "TCP"};
}

std::optional<std::size_t> Variables::find(std::string_view name, Scope scope) const {
  const std::string key = in_capitals(name), module{scope.module};
  for (const auto& [of_module, of_routine] : {std::pair{module, scope.routine}, {module, 0UZ}, {"", 0UZ}}) {
    if (const auto found = names_.find({of_module, of_routine, key}); found != names_.end())
      return found->second;
  }
  return std::nullopt;
}

std::optional<std::size_t> Variables::find_element(const Expression& element, Scope scope) const {
  const auto indices = plain_indices(element);
  const auto array = indices ? find(element.parts[0].name, scope) : std::nullopt;
  if (!array) return std::nullopt;
  const auto found = elements_.find({*array, *indices});
  return found == elements_.end() ? std::nullopt : std::optional{found->second};
}

void Variables::read_declarations(const SourceText& source, std::size_t file,
                                  const TextStatements& statements) {
  const bool is_config = source.role == SourceText::Role::Config;
  // Twice as much at least, since many files may follow each other.
  const std::size_t needed = variables_.size() + statements.declarations.size();
  if (needed > variables_.capacity()) variables_.reserve(std::max(needed, 2 * variables_.capacity()));
  statements.declarations.each([&](const ProgramStatement& statement) {
    const Declaration declaration = statement.declaration().value();
    declare(declaration, {source.module, statement.routine}, file, is_config || declaration.is_global);
  });
}

void Variables::declare(const Declaration& declaration, Scope scope, std::size_t file, bool is_global) {
  for (const Declaration::Name& declared : declaration.names) {
    const std::string name = declared.token.word();
    if (is_frame_table(name)) return;  // frames, and no positions
    const std::string module{scope.module};
    if (!names_.try_emplace({module, scope.routine, name}, variables_.size()).second)
      throw Fault{declared.token.at, std::string(declared.token.text) + " is declared twice; remove one"};
    if (is_global) names_.try_emplace({"", 0, name}, variables_.size());
    Variable& variable = variables_.emplace_back(Variable{.name = declared.token.text,
                                                          .type = type_of(declaration.type),
                                                          .declared = {file, declared.token.at},
                                                          .array = !declared.sizes.empty(),
                                                          .value = {},
                                                          .hindrance = {}});
    if (declared.value) give_value(variable, *declared.value, variable.declared);
  }
}

void Variables::read_uses(const SourceText& source, std::size_t file, const TextStatements& statements) {
  const bool is_program = source.role == SourceText::Role::Program;
  statements.uses.each([&](const ProgramStatement& statement) {
    if (statement.is_head) return;
    const Scope scope{source.module, statement.routine};
    if (const auto assignment = statement.assignment()) {
      if (is_program) read_frame_write(assignment->variable, scope, file);
      read_assignment(*assignment, scope, file);
    }
    for (const Expression& call : statement.calls()) read_arguments(call, scope, file);
    if (!is_program) return;
    for (const Expression& element : statement.elements()) read_chosen_element(element, scope, file);
  });
}

void Variables::read_assignment(const Assignment& assignment, Scope scope, std::size_t file) {
  const Expression& to = assignment.variable;
  const Spot spot{file, to.token.at};
  const auto index = find(to.root().name, scope);
  if (!index) return;
  Variable& variable = variables_[*index];
  if (variable.array) {
    give_element(*index, assignment, spot);
  } else if (to.kind != ExpressionKind::Name) {
    hinder(variable, message<Kind::Changed>("is changed"), spot);
  } else if (!std::holds_alternative<std::monostate>(variable.value)) {
    hinder(variable, message<Kind::Changed>("is given another value"), spot);
  } else {
    give_value(variable, assignment.value, spot);
  }
}

/// `WORK[3]={X ..}`, which is a variable of its own from there on, or a change of elements.
void Variables::give_element(std::size_t array, const Assignment& assignment, Spot spot) {
  const Expression& written = nearest(assignment.variable);
  const auto indices = plain_indices(written);
  if (!indices) return hinder_elements(array, message<Kind::Changed>("may be given another value"), spot);
  const bool is_whole = &written == &assignment.variable;
  const auto [entry, is_new] = elements_.try_emplace({array, *indices}, variables_.size());
  if (!is_new)
    return hinder(variables_[entry->second],
                  message<Kind::Changed>(is_whole ? "is given another value" : "is changed"), spot);
  const Variable whole = variables_[array];
  Variable& element = variables_.emplace_back(Variable{.name = written.text(),
                                                       .type = whole.type,
                                                       .declared = spot,
                                                       .is_element = true,
                                                       .value = {},
                                                       .hindrance = whole.hindrance});
  if (is_whole) return give_value(element, assignment.value, spot);
  hinder(element, message<Kind::Changed>("is changed"), spot);
}

/// All elements of an array, also those that get their value later.
void Variables::hinder_elements(std::size_t array, const Message& why, Spot spot) {
  hinder(variables_[array], why, spot);
  for (auto element = elements_.lower_bound({array, ""});
       element != elements_.end() && element->first.first == array; ++element)
    hinder(variables_[element->second], why, spot);
}

/// A motion to an element whose index is computed may go to any of them, with whatever frames.
void Variables::read_chosen_element(const Expression& variable, Scope scope, std::size_t file) {
  const auto index = find(variable.token.word(), scope);
  const bool is_of_points =
      index && variables_[*index].array && variables_[*index].type != VariableType::MotionData;
  if (is_of_points && !plain_indices(nearest(variable)))
    hinder_elements(*index, message<Kind::Index>(), {file, variable.token.at});
}

void Variables::read_frame_write(const Expression& variable, Scope scope, std::size_t file) {
  if (!is_frame_table(variable.root().name)) return;
  const Expression& written = nearest(variable);
  std::optional<int> index;
  if (written.kind == ExpressionKind::Element && written.parts.size() == 2)
    index = index_of(written.parts[1]);
  frame_writes_.emplace(std::tuple{std::string(scope.module), variable.root().name, index},
                        Spot{file, variable.token.at});
}

std::optional<Spot> Variables::frame_written(std::string_view module, std::string_view table,
                                             int number) const {
  for (const std::optional<int> index : {std::optional(number), std::optional<int>{}}) {
    const auto found = frame_writes_.find({std::string(module), std::string(table), index});
    if (found != frame_writes_.end()) return found->second;
  }
  return std::nullopt;
}

void Variables::read_arguments(const Expression& call, Scope scope, std::size_t file) {
  // Routines of the controller that take a position and leave it as it is.
  if (call.token.is_any_of({"FORWARD", "INVERSE", "INV_POS"})) return;
  for (const Expression& argument : call.parts) {
    const auto index = argument.kind == ExpressionKind::Name ? find(argument.name, scope) : std::nullopt;
    // An inline form hands its FDAT to routines of the controller, which leave it as it is.
    if (!index || variables_[*index].type == VariableType::MotionData) continue;
    hinder(variables_[*index], message<Kind::Argument>(call.token.text), {file, argument.token.at});
  }
}

}  // namespace truepose::krl
