#pragma once

#include <cstddef>
#include <expected>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace truepose::krl {

/// What is wrong with a text, and where (byte offset). One phrase: what; what to do.
struct Fault {
  std::size_t at = 0;
  std::string what;
};

enum class TokenKind {
  Name,     ///< XP1, $BASE, #TCP, DECL: KRL does not tell capitals from small letters
  Number,   ///< without a sign
  Text,     ///< "..."
  Literal,  ///< '...': a binary or hexadecimal number
  Symbol,   ///< any other byte
};

struct Token {
  TokenKind kind = TokenKind::Symbol;
  std::string_view text;
  std::size_t at = 0;  ///< byte offset of its first character

  std::size_t end() const { return at + text.size(); }
  bool is(char symbol) const { return kind == TokenKind::Symbol && text[0] == symbol; }
  /// @param word  in capitals
  bool is(std::string_view word) const;
  bool opens() const { return is('{') || is('[') || is('('); }
  bool closes() const { return is('}') || is(']') || is(')'); }
};

using Tokens = std::span<const Token>;

/// ASCII letters as capitals.
std::string in_capitals(std::string_view name);

/// Cuts a KRL text into statements. Comments and header lines (&ACCESS ...) are left out. A statement ends
/// with its line; a line that ends in a comma goes on in the next. Any bytes are taken.
class StatementReader {
 public:
  /// @param text  outlives the tokens
  explicit StatementReader(std::string_view text);

  /// @return the tokens of the next statement, valid until the next call; none at the end of the text.
  /// Errors: a text that is not closed in its line.
  std::expected<Tokens, Fault> next();

 private:
  std::expected<void, Fault> read_line();
  void add(TokenKind kind, std::size_t length);

  std::string_view text_;
  std::size_t at_ = 0;
  std::vector<Token> tokens_;
};

}  // namespace truepose::krl
