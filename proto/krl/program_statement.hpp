#pragma once

#include "proto/krl/statement.hpp"

namespace truepose::krl {

/// A statement of a program as far as it says where the arm goes. What cannot be read of it is left out,
/// since programs use what is not known here.
struct ProgramStatement {
  Statement tokens;
  bool is_head = false;     ///< of a routine: DEF or DEFFCT, which looks like a call of itself
  std::size_t routine = 0;  ///< number of its head in the text, the first = 1; 0: before any
  /// Of the tokens: what TRIGGER ... DO or INTERRUPT ... DO carries out later, else all.
  Tokens action;
  std::optional<Declaration> declaration;
  std::optional<Motion> motion;
  std::optional<Assignment> assignment;  ///< of the action; a value that cannot be read is Omitted
  std::vector<Assignment> settings;      ///< of SPLINE: WITH
  std::vector<Expression> calls;         ///< all of the action
  std::vector<Expression> elements;      ///< NAME[index], all of the action

  bool is_later() const { return action.data() != tokens.data(); }
  /// The call of BAS() that the action is; null where it is none.
  const Expression* bas() const;
};

using Statements = std::span<const ProgramStatement>;

/// Errors: a text or brace that is not closed, an aggregate with a component twice or more than 256 of them,
/// a number in one that is out of range.
std::expected<std::vector<ProgramStatement>, Fault> read_statements(std::string_view text);

}  // namespace truepose::krl
