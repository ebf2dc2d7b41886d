#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/krl/token_reader.hpp"

namespace truepose::krl {

enum class ExpressionKind {
  Constant,   ///< a number, a text, TRUE, FALSE
  Literal,    ///< #NAME
  Name,       ///< a variable
  Element,    ///< parts: the array, then its indices
  Whole,      ///< NAME[]; parts: the array
  Component,  ///< parts: the structure
  Call,       ///< parts: the arguments
  Omitted,    ///< an argument that is left out: F(1,,2)
  Unary,
  Binary,
  Aggregate,  ///< {X 1,Y 2}; names and parts: the components
};

struct Expression {
  ExpressionKind kind = ExpressionKind::Constant;
  Token token = {};  ///< its first, but for brackets around it
  /// In capitals: what it names, the component, the operator, or the type of an aggregate that says it.
  std::string name = {};
  std::vector<Expression> parts = {};
  std::vector<Token> names = {};
  std::size_t end = 0;  ///< byte offset behind its last token

  /// Its text, from its first byte to its last.
  std::string_view text() const { return {token.text.data(), end - token.at}; }
  /// Whether it names a variable or a part of one.
  bool is_variable() const;
  /// The variable that it is or is a part of. @pre is_variable()
  const Expression& root() const;
  /// The component of an aggregate. @param component  in capitals. @return null where it has none of that
  /// name
  const Expression* find(std::string_view component) const;
};

/// Reads an expression. Precedence, from the highest: sign, NOT, B_NOT; the geometric operator; * /; + -;
/// AND, B_AND; EXOR, B_EXOR; OR, B_OR; comparisons. Operators of one rank are taken from left to right.
/// Source: KUKA, KSS Expert Programming, "Priority of operators": there comparisons come last.
Expression read_expression(TokenReader& reader);

/// Reads a variable with its indices and components: what an assignment may begin with.
Expression read_variable(TokenReader& reader);

/// Reads NAME(a, b, ...).
Expression read_call(TokenReader& reader);

}  // namespace truepose::krl
