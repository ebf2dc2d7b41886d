#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace truepose::sim::krl {

enum class TokenKind {
  Name,     ///< $BASE, DECL, XP1; in capitals, as KRL does not tell them from small letters
  Literal,  ///< #T1, without its #; in capitals
  Integer,  ///< 12, 'H1F', 'B101'
  Real,     ///< 1.5, .5, 2., 1E-3
  Text,     ///< "...", without its quotation marks
  Symbol,   ///< ( ) == <= ...
};

struct Token {
  TokenKind kind = TokenKind::Symbol;
  std::string text;
  std::int32_t integer = 0;
  double real = 0;
  int line = 0;

  /// @param word  a symbol, or a name in capitals
  bool is(std::string_view word) const {
    return (kind == TokenKind::Name || kind == TokenKind::Symbol) && text == word;
  }
};

/// What stands in one line; a line that ends in a comma goes on in the next.
struct Statement {
  std::vector<Token> tokens;  ///< at least one
  int line = 0;
};

/// Cuts a KRL text into statements. Comments, folds and header lines (&ACCESS ...) are left out.
/// Throws Fault: a text that is not closed, a number too great, a character that KRL does not know.
std::vector<Statement> cut_into_statements(const std::string& file, std::string_view text);

/// ASCII letters as capitals.
std::string in_capitals(std::string_view name);

}  // namespace truepose::sim::krl
