#include "tools/sim/krl/statement_reader.hpp"

#include <algorithm>
#include <limits>

#include "proto/krl/places.hpp"

namespace truepose::sim::krl {
namespace {

constexpr std::string_view kSymbols = "()[]{},.:=+-*/<>";

/// What is wrong with a token; empty where nothing is.
std::string fault_of(const Token& token) {
  const auto number = token.number();
  switch (token.kind) {
    case TokenKind::Integer:
      if (number && *number <= std::numeric_limits<std::int32_t>::max()) return "";
      return "the number " + token.word() + " is too great";
    case TokenKind::Real:
      return number ? "" : "the number " + token.word() + " is too great";
    case TokenKind::Coded:
      return number ? "" : "a number such as 'H1F' or 'B101' is expected";
    case TokenKind::Constant:
      return token.text.size() > 1 ? "" : "# stands without the name of a constant";
    case TokenKind::Symbol:
      if (kSymbols.contains(token.text[0])) return "";
      if (token.is("'")) return "a number such as 'H1F' or 'B101' is expected";
      if (token.text[0] <= ' ' || token.text[0] > '~') return "a character that KRL does not know";
      return "the character " + token.word() + " does not belong here";
    default:
      return "";
  }
}

}  // namespace

std::vector<Statement> statements_of(const std::string& file, std::string_view text) {
  auto statements = truepose::krl::cut_into_statements(text);
  if (!statements) {
    const auto place = truepose::krl::Places(text).of(statements.error().at);
    throw Fault{file, static_cast<int>(place.line), "the text is not closed in its line"};
  }
  for (const Statement& statement : *statements) {
    for (const Token& token : statement) {
      if (std::string what = fault_of(token); !what.empty()) throw Fault{file, token.line, std::move(what)};
    }
  }
  return *std::move(statements);
}

std::int32_t integer_of(const Token& token) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(token.number().value_or(0)));
}

}  // namespace truepose::sim::krl
