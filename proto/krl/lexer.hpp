#pragma once

#include <cstddef>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace truepose::krl {

/// What is wrong with a text, and where (byte offset). One phrase: what; what to do. The readers of
/// statements throw it, since nearly each of their steps may find one; what reads a text gives it as a value.
struct Fault {
  std::size_t at = 0;
  std::string what;
};

enum class TokenKind {
  Name,      ///< XP1, $BASE, DECL: KRL does not tell capitals from small letters
  Constant,  ///< #TCP: of an enumeration
  Integer,   ///< 12, without a sign
  Real,      ///< 1.5, .5, 2., 1E-3
  Coded,     ///< '...': a whole number, as 'H1F' or 'B101'
  Text,      ///< "..."
  Symbol,    ///< ( ) == <= ..., and any other byte
};

struct Token {
  TokenKind kind = TokenKind::Symbol;
  std::string_view text;  ///< its bytes
  std::size_t at = 0;     ///< byte offset of its first character
  int line = 0;           ///< from 1

  std::size_t end() const { return at + text.size(); }
  /// @param word  a symbol, or a name or constant in capitals
  bool is(std::string_view word) const;
  bool is_any_of(std::initializer_list<std::string_view> words) const;
  /// A name or constant in capitals, without its #; a text without its quotation marks; else its bytes.
  std::string word() const;
  /// The value of an Integer, Real or Coded; none where it is another token or out of range.
  std::optional<double> number() const;
  bool opens() const { return is("{") || is("[") || is("("); }
  bool closes() const { return is("}") || is("]") || is(")"); }
};

using Tokens = std::span<const Token>;

/// ASCII letters as capitals.
std::string in_capitals(std::string_view name);

/// What stands in one line; a line that ends in a comma goes on in the next. At least one token.
using Statement = std::vector<Token>;

/// Cuts a KRL text into statements. Comments, folds and header lines (&ACCESS ...) are left out. Any bytes
/// are taken.
/// @param text  outlives the tokens
/// Errors: a text that is not closed in its line.
std::expected<std::vector<Statement>, Fault> cut_into_statements(std::string_view text);

}  // namespace truepose::krl
