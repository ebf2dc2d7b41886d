#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace truepose::krl {

/// What is wrong with a text, and where (byte offset). One phrase: what; what to do. The readers of
/// statements throw it, since nearly each of their steps may find one; what reads a text gives it as a value.
struct Fault {
  std::size_t at = 0;
  std::string what;
};

enum class TokenKind : std::uint8_t {
  Name,      ///< XP1, $BASE, DECL: KRL does not tell capitals from small letters
  Constant,  ///< #TCP: of an enumeration
  Integer,   ///< 12, without a sign
  Real,      ///< 1.5, .5, 2., 1E-3
  Coded,     ///< '...': a whole number, as 'H1F' or 'B101'
  Text,      ///< "..."
  Symbol,    ///< ( ) == <= ..., and any other byte
};

constexpr char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

struct Token {
  std::string_view text;  ///< its bytes
  std::size_t at = 0;     ///< byte offset of its first character
  int line = 0;           ///< from 1
  TokenKind kind = TokenKind::Symbol;

  std::size_t end() const { return at + text.size(); }
  /// @param word  a symbol, or a name or constant in capitals
  bool is(std::string_view word) const {
    return text.size() == word.size() && capital(text[0]) == word[0] && has_word() && spells(word);
  }
  bool is_any_of(std::initializer_list<std::string_view> words) const;
  /// Whether both are the same name.
  bool is_same_name(const Token& other) const;
  /// A name or constant in capitals, without its #; a text without its quotation marks; else its bytes.
  std::string word() const;
  /// The value of an Integer, Real or Coded; none where it is another token or out of range.
  std::optional<double> number() const;
  bool opens() const { return is("{") || is("[") || is("("); }
  bool closes() const { return is("}") || is("]") || is(")"); }

 private:
  bool has_word() const {
    return kind == TokenKind::Name || kind == TokenKind::Constant || kind == TokenKind::Symbol;
  }
  bool spells(std::string_view word) const;
};

using Tokens = std::span<const Token>;

/// ASCII letters as capitals.
std::string in_capitals(std::string_view name);

/// What stands in one line; a line that ends in a comma goes on in the next. At least one token.
using Statement = std::vector<Token>;

/// Cuts a KRL text into statements. Comments, folds and header lines (&ACCESS ...) are left out. Any bytes
/// are taken.
class Cutter {
 public:
  /// @param text  outlives the tokens
  explicit Cutter(std::string_view text);
  /// The next statement, until the one behind it is cut; empty at the end of the text. Throws Fault: a text
  /// that is not closed in its line.
  Tokens next();
  /// @param at  byte offset of a statement, which is the next. Lines are counted from there.
  void go_to(std::size_t at) { at_ = at; }

 private:
  void read_line();
  std::pair<TokenKind, std::size_t> first_of(std::string_view rest) const;
  std::pair<TokenKind, std::size_t> quoted(std::string_view rest) const;
  bool follows_variable() const;

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  Statement tokens_;
};

/// All statements of a text.
/// @param text  outlives the tokens
/// Errors: a text that is not closed in its line.
std::expected<std::vector<Statement>, Fault> cut_into_statements(std::string_view text);

}  // namespace truepose::krl
