#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "proto/krl/statement.hpp"
#include "tools/sim/krl/fault.hpp"

namespace truepose::sim::krl {

using truepose::krl::Assignment;
using truepose::krl::begins_routine;
using truepose::krl::Declaration;
using truepose::krl::Expression;
using truepose::krl::ExpressionKind;
using truepose::krl::in_capitals;
using truepose::krl::Statement;
using truepose::krl::Token;
using truepose::krl::TokenKind;
using truepose::krl::TokenReader;

/// Reads a statement of a file. Throws the interpreter's Fault, which names the file and the line.
class StatementReader : public TokenReader {
 public:
  /// @param file, statement  outlive the reader
  StatementReader(const std::string& file, const Statement& statement)
      : TokenReader(statement), file_{file} {}

  [[noreturn]] void fail(const std::string& what) const override { throw Fault{file_, here().line, what}; }

 private:
  const std::string& file_;
};

/// Cuts a file into statements. Throws Fault: a text that is not closed, a number too great, a character that
/// KRL does not know.
/// @param text  outlives the statements
std::vector<Statement> statements_of(const std::string& file, std::string_view text);

/// The value of an Integer or Coded number, which statements_of() has looked at.
std::int32_t integer_of(const Token& token);

}  // namespace truepose::sim::krl
