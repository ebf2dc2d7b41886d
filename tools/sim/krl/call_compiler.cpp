// The part of ExpressionCompiler that calls subprograms.
#include <algorithm>

#include "tools/sim/krl/expression_compiler.hpp"

namespace truepose::sim::krl {

void ExpressionCompiler::call_statement(const Expression& expression) {
  if (call(expression).kind != Kind::None) scope_.emit(Op::Drop);
}

Type ExpressionCompiler::call(const Expression& expression) {
  const std::string& name = expression.name;
  if (name == "ABS") return absolute(expression);
  if (name == "INV_POS") return inverse_pose(expression);
  if (name == "VARSTATE") return variable_state(expression);
  if (name == "SWRITE") return string_write(expression);
  if (name == "SREAD") return string_read(expression);
  if (const auto routine = scope_.symbols.find_routine(name, scope_.module))
    return call_routine(expression, *routine);
  if (const auto external = scope_.symbols.find_external(name)) return call_external(expression, *external);
  scope_.fail("the subprogram " + name + " is not known" + scope_.symbols.why_unknown(name));
}

Type ExpressionCompiler::call_routine(const Expression& expression, std::size_t index) {
  if (!scope_.aside.empty()) fail_aside(expression);
  arguments(expression, scope_.symbols.program.routines[index].parameters);
  const Type result = scope_.symbols.program.routines[index].result;
  scope_.emit(Op::Call, index, result.kind == Kind::None ? 0 : 1);
  return result;
}

Type ExpressionCompiler::call_external(const Expression& expression, std::size_t index) {
  const External external = scope_.symbols.program.externals[index];
  if (!scope_.aside.empty() && !external.is_builtin) fail_aside(expression);
  arguments(expression, external.parameters);
  if (!external.passes_advance_run) scope_.stop_advance_run();
  scope_.emit(Op::CallExternal, index, external.parameters.size());
  return external.result;
}

void ExpressionCompiler::fail_aside(const Expression& expression) {
  const std::string what = scope_.aside == "trigger"     ? "what a trigger sets"
                           : scope_.aside == "interrupt" ? "the condition of an interrupt"
                                                         : "a cyclical flag";
  scope_.fail(what + " cannot call " + expression.name);
}

void ExpressionCompiler::count_arguments(const Expression& expression, std::size_t expected) {
  if (expression.parts.size() == expected) return;
  scope_.fail(expression.name + " takes " + std::to_string(expected) + " parameters, not " +
              std::to_string(expression.parts.size()));
}

void ExpressionCompiler::arguments(const Expression& expression, const std::vector<Parameter>& parameters) {
  if (expression.parts.size() > parameters.size()) count_arguments(expression, parameters.size());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const std::string what = "parameter " + std::to_string(i + 1) + " of " + expression.name;
    const bool is_given = i < expression.parts.size() && expression.parts[i].kind != ExpressionKind::Omitted;
    is_given ? argument(expression.parts[i], parameters[i], what) : omitted(parameters[i]);
  }
}

/// What a call leaves out has no value: a subprogram asks with VARSTATE, as KUKA's MsgLib does.
void ExpressionCompiler::omitted(const Parameter& parameter) {
  const Type& type = parameter.type;
  const bool is_open = std::ranges::count(type.sizes, 0) > 0;
  Type sized = type;
  if (is_open) std::ranges::replace(sized.sizes, 0, 1);
  if (parameter.direction == Direction::In) return scope_.push(scope_.types().blank(sized));
  scope_.emit(Op::Local, scope_.add_hidden(sized));
}

void ExpressionCompiler::argument(const Expression& given, const Parameter& parameter,
                                  const std::string& what) {
  if (parameter.direction == Direction::Out) return out_argument(given, parameter.type, what);
  value_as(given, parameter.type, what);
}

Type ExpressionCompiler::absolute(const Expression& expression) {
  count_arguments(expression, 1);
  const Type type = value(expression.parts[0]);
  if (!type.is_number()) scope_.fail("ABS takes a number, not " + type_name(type));
  scope_.emit(Op::Absolute);
  return type;
}

Type ExpressionCompiler::inverse_pose(const Expression& expression) {
  count_arguments(expression, 1);
  const Type type = value(expression.parts[0]);
  if (!is_frame(type)) scope_.fail("INV_POS takes a frame or position, not " + type_name(type));
  scope_.emit(Op::InversePose, static_cast<std::size_t>(type.id));
  return type;
}

Type ExpressionCompiler::variable_state(const Expression& expression) {
  count_arguments(expression, 1);
  const Token& text = expression.parts[0].token;
  if (text.kind != TokenKind::Text) scope_.fail("VARSTATE is known here with a text constant only");
  const Type result = *scope_.types().find("VAR_STATE");
  const std::string& file = scope_.symbols.program.files[static_cast<std::size_t>(scope_.file)];
  const std::size_t before = scope_.here();
  try {
    const std::vector<Statement> inside = statements_of(file, text.text.substr(1, text.text.size() - 2));
    if (inside.size() != 1) scope_.fail("no variable");
    StatementReader reader(file, inside[0]);
    const Expression variable = read_variable(reader);
    reader.expect_end();
    place(variable);
    scope_.emit(Op::VariableState);
  } catch (const Fault&) {
    scope_.symbols.program.code.resize(before);
    scope_.push(Literal{"UNKNOWN"});
  }
  return result;
}

Type ExpressionCompiler::string_write(const Expression& expression) {
  const std::size_t external = format_arguments(expression);
  for (std::size_t i = 4; i < expression.parts.size(); ++i) {
    const Type type = value(expression.parts[i]);
    if (!type.is_simple()) scope_.fail("SWRITE cannot write " + type_name(type));
  }
  scope_.emit(Op::CallExternal, external, expression.parts.size());
  return {};
}

Type ExpressionCompiler::string_read(const Expression& expression) {
  const std::size_t external = format_arguments(expression);
  constexpr std::size_t kFirst = 4;
  for (std::size_t i = kFirst; i < expression.parts.size(); ++i) {
    const Expression& variable = expression.parts[i];
    if (!variable.is_variable()) scope_.fail("SREAD reads into variables");
    const Type type = whole_place(variable);
    if (!type.is_simple()) scope_.fail("SREAD cannot read " + type_name(type));
    scope_.push(Literal{type.is_text() ? "TEXT" : type_name(type)});
  }
  scope_.emit(Op::CallExternal, external, 2 * expression.parts.size() - kFirst);
  return {};
}

/// What SREAD and SWRITE begin with. @return the subprogram
std::size_t ExpressionCompiler::format_arguments(const Expression& expression) {
  const std::string& name = expression.name;
  if (expression.parts.size() < 4)
    scope_.fail(name + " takes a text, a state, an offset, a format and " +
                (name == "SREAD" ? "variables" : "values"));
  const std::size_t index = *scope_.symbols.find_external(name);
  const std::vector<Parameter> parameters = scope_.symbols.program.externals[index].parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    argument(expression.parts[i], parameters[i], "parameter " + std::to_string(i + 1) + " of " + name);
  return index;
}

}  // namespace truepose::sim::krl
