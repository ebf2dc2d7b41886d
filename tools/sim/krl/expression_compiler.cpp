#include "tools/sim/krl/expression_compiler.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "proto/krl/position.hpp"

namespace truepose::sim::krl {
namespace {

const std::map<std::string_view, Op> kArithmetic = {
    {"+", Op::Add}, {"-", Op::Subtract}, {"*", Op::Multiply}, {"/", Op::Divide}};
const std::map<std::string_view, Op> kLogic = {{"AND", Op::And}, {"OR", Op::Or}, {"EXOR", Op::Exor}};
const std::map<std::string_view, Op> kBits = {
    {"B_AND", Op::BitAnd}, {"B_OR", Op::BitOr}, {"B_EXOR", Op::BitExor}};
const std::map<std::string_view, Op> kComparisonOps = {{"==", Op::Equal},     {"<>", Op::Unequal},
                                                       {"<", Op::Less},       {">", Op::Greater},
                                                       {"<=", Op::LessEqual}, {">=", Op::GreaterEqual}};

/// Whether the other side of a comparison tells its type.
bool needs_other_side(const Expression& expression) {
  const bool is_text =
      expression.kind == ExpressionKind::Constant && expression.token.kind == TokenKind::Text;
  return expression.kind == ExpressionKind::Literal || is_text;
}

}  // namespace

Type ExpressionCompiler::value(const Expression& expression) {
  switch (expression.kind) {
    case ExpressionKind::Constant:
      return constant(expression.token);
    case ExpressionKind::Literal:
      scope_.fail("the enumeration is not known of #" + expression.name);
    case ExpressionKind::Name:
    case ExpressionKind::Element:
    case ExpressionKind::Whole:
    case ExpressionKind::Component:
      return variable_value(expression);
    case ExpressionKind::Call:
      return call(expression);
    case ExpressionKind::Unary:
      return unary(expression);
    case ExpressionKind::Binary:
      return binary(expression);
    case ExpressionKind::Omitted:
      scope_.fail("a value is missing");
    case ExpressionKind::Aggregate:
      break;
  }
  const auto type = scope_.types().find(expression.name);
  if (!type || type->kind != Kind::Structure) scope_.fail("the structure of {...} is not known");
  return aggregate(expression, *type);
}

void ExpressionCompiler::value_as(const Expression& expression, const Type& type, const std::string& what) {
  if (expression.kind == ExpressionKind::Literal) {
    if (!type.is(Kind::Enumeration)) scope_.fail(what + " is " + type_name(type) + ", not an enumeration");
    if (!scope_.types().enumeration(type).has(expression.name))
      scope_.fail("the enumeration " + type_name(type) + " has no #" + expression.name);
    return scope_.push(Literal{expression.name});
  }
  if (expression.kind == ExpressionKind::Constant && expression.token.kind == TokenKind::Text &&
      type.is(Kind::Char)) {
    if (expression.name.size() != 1) scope_.fail(what + " is CHAR and takes one character");
    return scope_.push(expression.name[0]);
  }
  if (expression.kind == ExpressionKind::Aggregate && expression.name.empty() && type.is(Kind::Structure)) {
    aggregate(expression, type);
    return;
  }
  convert(value(expression), type, what);
}

void ExpressionCompiler::convert(const Type& from, const Type& to, const std::string& what) {
  const Types& types = scope_.types();
  const auto both = [&](auto is) { return is(from) && is(to); };
  if (from.is_number() && to.is(Kind::Real)) {
    scope_.emit(Op::ToReal);
  } else if (from.is(Kind::Real) && to.is(Kind::Int)) {
    scope_.emit(Op::ToInt);
  } else if (from.is(Kind::Char) && to.is(Kind::Int)) {
    scope_.emit(Op::ToCode);
  } else if (from.is(Kind::Int) && to.is(Kind::Char)) {
    scope_.emit(Op::ToChar);
  } else if (from == to || (from.is_text() && to.is_text())) {
    return;
  } else if (both([&](const Type& t) { return is_frame(t); }) ||
             both([&](const Type& t) { return is_axes(t); })) {
    scope_.emit(Op::Reshape, static_cast<std::size_t>(from.id), static_cast<std::size_t>(to.id));
  } else {
    scope_.fail(what + " is " + types.name(to) + " and gets " + types.name(from));
  }
}

Type ExpressionCompiler::place(const Expression& expression) {
  switch (expression.kind) {
    case ExpressionKind::Name:
      return name(expression);
    case ExpressionKind::Element:
      return element(expression);
    case ExpressionKind::Whole: {
      const Type type = place(expression.parts[0]);
      if (!type.is_array()) scope_.fail("[] stands behind a variable that is no array");
      return type;
    }
    case ExpressionKind::Component:
      return component(expression);
    default:
      scope_.fail("a variable is expected");
  }
}

Type ExpressionCompiler::name(const Expression& expression) {
  const Symbol symbol = scope_.variable(expression.name);
  const Op op = symbol.storage == Storage::Local    ? Op::Local
                : symbol.storage == Storage::Global ? Op::Global
                                                    : Op::System;
  if (!symbol.passes_advance_run) scope_.stop_advance_run();
  scope_.emit(op, symbol.slot);
  if (!symbol.element) return symbol.type;
  if (symbol.bits > 0) {
    scope_.emit(Op::Bits, static_cast<std::size_t>(*symbol.element) - 1,
                static_cast<std::size_t>(symbol.bits));
    return {Kind::Int};
  }
  scope_.push(*symbol.element);
  scope_.emit(Op::Index);
  return symbol.type.element();
}

Type ExpressionCompiler::element(const Expression& expression) {
  Type type = place(expression.parts[0]);
  for (std::size_t i = 1; i < expression.parts.size(); ++i) {
    if (!type.is_array()) scope_.fail("an index stands behind a variable that is no array");
    const Type index = value(expression.parts[i]);
    if (!index.is(Kind::Int)) scope_.fail("an index is INT, not " + type_name(index));
    scope_.emit(Op::Index);
    type = type.element();
  }
  return type;
}

Type ExpressionCompiler::component(const Expression& expression) {
  const Type type = place(expression.parts[0]);
  if (!type.is(Kind::Structure)) scope_.fail(type_name(type) + " has no component " + expression.name);
  const Structure& structure = scope_.types().structure(type);
  const auto index = structure.find(expression.name);
  if (!index) scope_.fail(structure.name + " has no component " + expression.name);
  scope_.emit(Op::Field, static_cast<std::size_t>(*index));
  return structure.fields[static_cast<std::size_t>(*index)].type;
}

Type ExpressionCompiler::variable_value(const Expression& expression) {
  const std::size_t before = scope_.here();
  const Type type = whole_place(expression);
  scope_.fetch(before);
  return type;
}

Type ExpressionCompiler::whole_place(const Expression& expression) {
  const Type type = place(expression);
  if (type.is_array() && expression.kind != ExpressionKind::Whole)
    scope_.fail("an array as a whole is written with []");
  return type;
}

Type ExpressionCompiler::constant(const Token& token) {
  switch (token.kind) {
    case TokenKind::Integer:
    case TokenKind::Coded:
      scope_.push(integer_of(token));
      return {Kind::Int};
    case TokenKind::Real:
      scope_.push(*token.number());
      return {Kind::Real};
    case TokenKind::Text:
      scope_.push(token.word());
      return {Kind::Char, -1, {static_cast<int>(token.word().size())}};
    default:
      scope_.push(token.is("TRUE"));
      return {Kind::Bool};
  }
}

Type ExpressionCompiler::unary(const Expression& expression) {
  const Type type = value(expression.parts[0]);
  const std::string& symbol = expression.name;
  const bool fits = symbol == "NOT"     ? type.is(Kind::Bool)
                    : symbol == "B_NOT" ? type.is(Kind::Int)
                                        : type.is_number();
  if (!fits) scope_.fail(symbol + " does not go with " + type_name(type));
  if (symbol != "+") scope_.emit(symbol == "NOT" ? Op::Not : symbol == "B_NOT" ? Op::BitNot : Op::Negate);
  return type;
}

Type ExpressionCompiler::binary(const Expression& expression) {
  const std::string& symbol = expression.name;
  if (kComparisonOps.contains(symbol)) return comparison(expression);
  const bool is_geometric = symbol == ":";
  const Type left = is_geometric ? frame(expression.parts[0]) : value(expression.parts[0]);
  const Type right = is_geometric ? frame(expression.parts[1]) : value(expression.parts[1]);
  const auto both = [&](Kind kind) { return left.is(kind) && right.is(kind); };
  if (const auto op = kArithmetic.find(symbol);
      op != kArithmetic.end() && left.is_number() && right.is_number()) {
    scope_.emit(op->second);
    return both(Kind::Int) ? Type{Kind::Int} : Type{Kind::Real};
  }
  if (const auto op = kLogic.find(symbol); op != kLogic.end() && both(Kind::Bool)) {
    scope_.emit(op->second);
    return {Kind::Bool};
  }
  if (const auto op = kBits.find(symbol); op != kBits.end() && both(Kind::Int)) {
    scope_.emit(op->second);
    return {Kind::Int};
  }
  if (is_geometric && is_frame(left) && is_frame(right)) {
    scope_.emit(Op::Compose, static_cast<std::size_t>(left.id), static_cast<std::size_t>(right.id));
    return right;
  }
  scope_.fail(symbol + " does not go with " + type_name(left) + " and " + type_name(right));
}

Type ExpressionCompiler::comparison(const Expression& expression) {
  const Expression &left = expression.parts[0], &right = expression.parts[1];
  const std::string& symbol = expression.name;
  const bool is_equality = symbol == "==" || symbol == "<>";
  // The enumeration of a constant is that of the other side; equality does not mind the order.
  if (is_equality && needs_other_side(left) && !needs_other_side(right)) {
    compared(right, left, true);
  } else {
    compared(left, right, is_equality);
  }
  scope_.emit(kComparisonOps.find(symbol)->second);
  return {Kind::Bool};
}

void ExpressionCompiler::compared(const Expression& left, const Expression& right, bool is_equality) {
  const Type type = value(left);
  const bool has_order = type.is_number() || type.is(Kind::Char);
  if (!is_equality && !has_order) scope_.fail(type_name(type) + " has no order");
  if (type.is_array() || type.kind == Kind::Structure || type.kind == Kind::None)
    scope_.fail(type_name(type) + " cannot be compared");
  if (needs_other_side(right)) return value_as(right, type, "the left side");
  const Type other = value(right);
  const auto is_code = [](const Type& t) { return t.is(Kind::Int) || t.is(Kind::Char); };
  if (type != other && !(type.is_number() && other.is_number()) && !(is_code(type) && is_code(other)))
    scope_.fail(type_name(type) + " cannot be compared with " + type_name(other));
}

Type ExpressionCompiler::aggregate(const Expression& expression, const Type& type) {
  const Structure structure = scope_.types().structure(type);
  std::vector<int> shape;
  for (std::size_t i = 0; i < expression.names.size(); ++i) {
    const std::string field = expression.names[i].word();
    const auto index = structure.find(field);
    if (!index) scope_.fail(structure.name + " has no component " + field);
    if (std::ranges::count(shape, *index) > 0) scope_.fail(field + " is given twice");
    shape.push_back(*index);
    value_as(expression.parts[i], structure.fields[static_cast<std::size_t>(*index)].type,
             "the component " + field);
  }
  scope_.symbols.program.shapes.push_back(std::move(shape));
  scope_.emit(Op::Gather, static_cast<std::size_t>(type.id), scope_.symbols.program.shapes.size() - 1);
  return type;
}

Type ExpressionCompiler::frame(const Expression& expression) {
  if (expression.kind != ExpressionKind::Aggregate || !expression.name.empty()) return value(expression);
  const bool has_status = std::ranges::any_of(expression.names, [](const Token& name) {
    return name.is_any_of({"S", "T"});
  });
  return aggregate(expression, *scope_.types().find(has_status ? "POS" : "FRAME"));
}

Type ExpressionCompiler::target(const Expression& expression) {
  Type type;
  if (expression.kind == ExpressionKind::Aggregate && expression.name.empty()) {
    const bool is_of_axes = form_of(expression) == truepose::krl::PositionForm::Axes;
    type = aggregate(expression, *scope_.types().find(is_of_axes ? "E6AXIS" : "E6POS"));
  } else {
    type = value(expression);
  }
  if (!is_axes(type) && !is_frame(type)) scope_.fail("a motion cannot go to " + type_name(type));
  return type;
}

void ExpressionCompiler::assign(const Expression& target, const Expression& source) {
  const std::string& name = target.root().name;
  if (scope_.variable(name).is_constant) scope_.fail(name + " is constant and cannot be set");
  initialise(target, source);
}

void ExpressionCompiler::initialise(const Expression& target, const Expression& source) {
  const Type type = whole_place(target);
  value_as(source, type, "the variable " + target.root().name);
  scope_.emit(Op::Store);
}

bool ExpressionCompiler::is_frame(const Type& type) const {
  const Types& types = scope_.types();
  return types.is_structure(type, "FRAME") || types.is_structure(type, "POS") ||
         types.is_structure(type, "E6POS");
}

bool ExpressionCompiler::is_axes(const Type& type) const {
  return scope_.types().is_structure(type, "AXIS") || scope_.types().is_structure(type, "E6AXIS");
}

void ExpressionCompiler::out_argument(const Expression& argument, const Type& type, const std::string& what) {
  if (!argument.is_variable()) scope_.fail(what + " is OUT and needs a variable");
  const Type given = whole_place(argument);
  const bool fits_as_array = type.is_array() && given.sizes.size() == type.sizes.size() &&
                             given.kind == type.kind && given.id == type.id;
  if (given != type && !fits_as_array)
    scope_.fail(what + " is " + type_name(type) + " and gets " + type_name(given));
}

}  // namespace truepose::sim::krl
