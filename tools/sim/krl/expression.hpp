#pragma once

#include <string>
#include <vector>

#include "tools/sim/krl/token_reader.hpp"

namespace truepose::sim::krl {

enum class ExpressionKind {
  Constant,   ///< a number, a text, TRUE, FALSE
  Literal,    ///< #NAME
  Name,       ///< a variable
  Element,    ///< parts: the array, then its indices
  Whole,      ///< NAME[]; parts: the array
  Component,  ///< parts: the structure; token: the component
  Call,       ///< token: the name; parts: the arguments
  Omitted,    ///< an argument that is left out: F(1,,2)
  Unary,      ///< token: the operator
  Binary,     ///< token: the operator
  Aggregate,  ///< {X 1,Y 2}; token: the type's name or empty; names and parts: the components
};

struct Expression {
  ExpressionKind kind = ExpressionKind::Constant;
  Token token;
  std::vector<Expression> parts;
  std::vector<std::string> names;
};

/// Reads an expression. Precedence, from the highest: sign, NOT, B_NOT; the geometric operator; * /; + -;
/// AND, B_AND; EXOR, B_EXOR; OR, B_OR; comparisons. Operators of one rank are taken from left to right.
/// Source: KUKA, KSS Expert Programming, "Priority of operators": there comparisons come last.
/// Throws Fault.
Expression read_expression(TokenReader& reader);

/// Reads a variable with its indices and components: what an assignment may begin with.
Expression read_variable(TokenReader& reader);

/// Whether it names a variable or a part of one.
bool is_variable(const Expression& expression);

/// Reads (a, b, ...) behind the name of a subprogram.
Expression read_call(TokenReader& reader, Token name);

}  // namespace truepose::sim::krl
